#!/usr/bin/env python3
"""The source tree keeps the rules of the house: who includes whom, how long a file is, what stands in it."""
import pathlib
import re
import sys
import unittest

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).parent))
import layers  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parents[3]
INCLUDE = re.compile(r'^\s*#\s*include\s*[<"]([^>"]+)[>"]', re.M)
SOURCES = (".cpp", ".h")
TEXT = SOURCES + (".py", ".sh", ".md", ".yaml", ".yml", ".xml", ".idl", ".txt", ".cmake", ".conf", ".json")
FOLDERS = ("libs", "services", "tools", "tests", "idl", "cmake", "compose", "configs", "docs")


def files(folder, suffixes):
    return sorted(p for p in (ROOT / folder).rglob("*") if p.is_file() and p.suffix in suffixes)


def includes(path):
    return INCLUDE.findall(path.read_text(encoding="utf-8"))


def generated_headers():
    stems = [p.stem for p in (ROOT / "idl").glob("*.idl")]
    return {f"{stem}{ending}.h" for stem in stems for ending in ("", "PubSubTypes")}


def folder_of(path):
    """The folder of the table that a source file belongs to: libs/scene/… → scene, services/… → services."""
    parts = path.relative_to(ROOT).parts
    return parts[1] if parts[0] == "libs" else parts[0]


class IncludeGraph(unittest.TestCase):
    def setUp(self):
        self.sources = [p for f in ("libs", "services", "tools") for p in files(f, SOURCES)]
        self.assertGreater(len(self.sources), 20, "the source tree was not found")

    def test_every_library_is_in_the_table(self):
        found = {p.name for p in (ROOT / "libs").iterdir() if p.is_dir() and any(p.iterdir())}
        self.assertLessEqual(found, set(layers.ALLOWED), "give the new library its row in layers.py")

    def test_the_table_has_no_cycle(self):
        def reach(folder, path):
            for other in layers.ALLOWED[folder] - {folder}:
                self.assertNotIn(other, path, f"{' → '.join(path)} → {other}")
                reach(other, path + [other])
        for folder in ("study", "service"):
            reach(folder, [folder])

    def test_includes_go_one_way(self):
        wrong = []
        for path in self.sources:
            folder = folder_of(path)
            for name in includes(path):
                other = name.split("/")[0]
                if "/" in name and other in layers.ALLOWED and (ROOT / "libs" / name).exists():
                    if other != folder and other not in layers.ALLOWED[folder]:
                        wrong.append(f"{path.relative_to(ROOT)} includes {name}: {folder} may not use {other}")
        self.assertEqual(wrong, [])

    def test_a_quoted_include_names_a_file_of_the_project(self):
        known = generated_headers()
        wrong = []
        for path in self.sources:
            for name in re.findall(r'^\s*#\s*include\s*"([^"]+)"', path.read_text(encoding="utf-8"), re.M):
                places = [ROOT / "libs" / name, path.parent / name, ROOT / "services" / name, ROOT / "tools" / name]
                if name not in known and not any(p.exists() for p in places):
                    wrong.append(f"{path.relative_to(ROOT)}: {name}")
        self.assertEqual(wrong, [])

    def test_only_the_bus_sees_the_transport(self):
        wrong = [f"{p.relative_to(ROOT)} includes {n}" for p in self.sources for n in includes(p)
                 if n.startswith(layers.TRANSPORT) and folder_of(p) not in layers.MAY_SEE_TRANSPORT]
        self.assertEqual(wrong, [])

    def test_only_bus_wire_and_what_stands_on_them_see_generated_types(self):
        generated = generated_headers()
        wrong = [f"{p.relative_to(ROOT)} includes {n}" for p in self.sources for n in includes(p)
                 if n in generated and folder_of(p) not in layers.MAY_SEE_GENERATED]
        self.assertEqual(wrong, [])

    def test_only_wire_converts_between_generated_and_library_types(self):
        pure = layers.PURE - {"core", "config"}
        generated = generated_headers()
        wrong = []
        for path in (p for p in self.sources if folder_of(p) in ("bus", "service")):
            names = includes(path)
            if any(n in generated for n in names) and any(n.split("/")[0] in pure for n in names):
                wrong.append(str(path.relative_to(ROOT)))
        self.assertEqual(wrong, [])


class Text(unittest.TestCase):
    def test_no_source_file_is_too_long(self):
        long = [f"{p.relative_to(ROOT)}: {n} lines" for f in ("libs", "services", "tools", "tests", "idl")
                for p in files(f, SOURCES + (".idl", ".py"))
                if (n := len(p.read_text(encoding="utf-8").splitlines())) > layers.MAX_LINES]
        self.assertEqual(long, [], "more than one subject? split it")

    def test_no_path_of_somebodys_machine(self):
        pattern = re.compile(r"(?<![\w.])/(home|root|work|Users|mnt)/\w")
        wrong = [f"{p.relative_to(ROOT)}: {m.group(0)}" for f in FOLDERS if (ROOT / f).exists()
                 for p in files(f, TEXT) if p.resolve() != pathlib.Path(__file__).resolve()
                 for m in [pattern.search(p.read_text(encoding="utf-8"))] if m]
        self.assertEqual(wrong, [])

    def test_nothing_is_left_for_later(self):
        pattern = re.compile(r"\b(TODO|FIXME|XXX)\b")
        wrong = [f"{p.relative_to(ROOT)}" for f in ("libs", "services", "tools", "idl", "compose")
                 for p in files(f, TEXT) if pattern.search(p.read_text(encoding="utf-8"))]
        self.assertEqual(wrong, [])

    def test_a_header_is_guarded_and_says_what_it_is(self):
        wrong = []
        for path in (p for f in ("libs", "services", "tools") for p in files(f, (".h",))):
            text = path.read_text(encoding="utf-8")
            if not text.startswith("//") or "#pragma once" not in text:
                wrong.append(str(path.relative_to(ROOT)))
        self.assertEqual(wrong, [], "begin with a sentence on the file's subject, then #pragma once")


class Documents(unittest.TestCase):
    def test_links_between_pages_lead_somewhere(self):
        pages = [ROOT / n for n in ("README.md", "CONTRIBUTING.md", "CHANGELOG.md")] + files("docs", (".md",)) + files("idl", (".md",))
        wrong = []
        for page in (p for p in pages if p.exists()):
            for target in re.findall(r"\]\(([^)#\s]+)", page.read_text(encoding="utf-8")):
                if not re.match(r"\w+:", target) and not (page.parent / target).exists():
                    wrong.append(f"{page.relative_to(ROOT)}: {target}")
        self.assertEqual(wrong, [])

    def test_every_file_named_by_the_equations_page_exists(self):
        page = ROOT / "docs" / "equations.md"
        names = re.findall(r"`((?:libs|configs|services|tests)/[\w./*-]+)`", page.read_text(encoding="utf-8"))
        self.assertGreater(len(names), 5)
        self.assertEqual([n for n in names if not list(ROOT.glob(n))], [])

    def test_every_decision_is_in_the_index(self):
        folder = ROOT / "docs" / "decisions"
        index = (folder / "README.md").read_text(encoding="utf-8")
        pages = [p.name for p in folder.glob("[0-9]*.md")]
        self.assertEqual([p for p in pages if p not in index], [])

    def test_every_type_of_the_topic_table_stands_in_the_idl(self):
        table = (ROOT / "idl" / "topics.md").read_text(encoding="utf-8")
        idl = "\n".join(p.read_text(encoding="utf-8") for p in (ROOT / "idl").glob("*.idl"))
        structs = set(re.findall(r"\bstruct\s+(\w+)", idl))
        rows = [line for line in table.splitlines() if line.startswith("|") and "rt/" in line or "primo/v1" in line]
        self.assertGreater(len(rows), 5)
        named = {t for line in rows for t in re.findall(r"`(?:\w+(?:::|/))*([A-Z]\w+)`", line)}
        self.assertLessEqual({t for t in named if t[0].isupper() and not t.isupper()}, structs)


if __name__ == "__main__":
    unittest.main(verbosity=1)
