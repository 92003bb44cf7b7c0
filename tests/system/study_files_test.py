"""primo study diff and export, and what primo config says of study files."""
import csv
import json
import pathlib
import tempfile
import unittest

from running_graph import primo as ask

ROOT = pathlib.Path(__file__).resolve().parents[2]


def primo(*words, code=0):
    exit_code, out, err = ask(*map(str, words))
    assert exit_code == code, f"{words}: {exit_code}\n{out}\n{err}"
    return out + err


class StudyFiles(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory(prefix="primo-study-files-")
        cls.addClassCleanup(folder.cleanup)
        cls.folder = pathlib.Path(folder.name)
        base = (f"robot: {ROOT}/configs/robots/schunk_lwa3_sdh2.yaml\n"
                f"primitive: {ROOT}/configs/primitives/grasp_hand_tuned.yaml\n"
                f"training: [{ROOT}/configs/scenarios/example.yaml]\ngoal: [[inhand, X]]\n"
                "experience: {scenarios: 6}\noptimizer: {evaluations: 8, population: 4, validation: 1}\nexecuted: 2\n"
                "generalization: {levels: [0, 0.05], scenarios: 4, executed: 2, tables: [0.05]}\n")
        (cls.folder / "base.yaml").write_text("name: base\n" + base)
        (cls.folder / "study.yaml").write_text("include: base.yaml\nname: study\n")
        cls.home = cls.folder / "run"
        cls.output = primo("study", "run", cls.folder / "study.yaml", "--local", "--directory", cls.home)

    def test_run_tells_held_out_scenes_and_draws_them(self):
        self.assertIn("held-out scenarios", self.output)
        result = json.loads((self.home / "result.json").read_text())
        levels = result["parts"][0]["levels"]
        self.assertEqual([level["displacement"] for level in levels], [0, 0.05])
        for level in levels:
            pair = level["paired"]["strict"]
            self.assertEqual(sum(pair.values()), 4)
            self.assertEqual(level["before"]["strict"]["successes"], pair["both"] + pair["first_only"])
        rates = list(csv.DictReader((self.home / "report" / "rates.csv").read_text().splitlines()))
        self.assertEqual(len(rates), 2 * 2 * 3)
        self.assertEqual({r["trials"] for r in rates if r["verdict"] == "executed"}, {"2"})
        for name in ("grasp_success.svg", "grasp_gamma.csv", "grasp_generalization_executed.png", "grasp_rates.tex",
                     "grasp_rules.tex", "causes.csv", "index.html"):
            self.assertTrue((self.home / "report" / name).exists(), name)

    def test_export_gives_the_experiences_as_lines_and_as_csv(self):
        lines = primo("study", "export", self.home).splitlines()
        self.assertEqual(len(lines), 12, "six with P, six with P*")
        file = self.folder / "experience.csv"
        primo("study", "export", self.home, "--format", "csv", "--out", file)
        rows = list(csv.DictReader(file.read_text().splitlines()))
        self.assertEqual(len(rows), 12)
        for row, line in zip(rows, lines):
            experience = json.loads(line)
            before = {tuple(l) for l in experience["s"]}
            added = [l for l in experience["s2"] if tuple(l) not in before]
            self.assertEqual(len(row["added"].split()), len(added), row)
            self.assertEqual(row["action"], "grasp(c1)")
        # What was exported is what the rule learner reads.
        (self.folder / "lines.jsonl").write_text("\n".join(lines) + "\n")
        primo("rules", "learn", "--experiences", self.folder / "lines.jsonl", "--out", self.folder / "rules.json")

    def test_diff_names_every_key_and_shows_results_side_by_side(self):
        self.assertIn("the same settings", primo("study", "diff", self.home, self.folder / "study.yaml"))
        (self.folder / "other.yaml").write_text("include: base.yaml\nname: study\nseed: 99\n")
        text = primo("study", "diff", self.folder / "study.yaml", self.folder / "other.yaml")
        self.assertEqual(text.strip(), "parts[0].seed: 1 | 99")
        self.assertIn("held out ±5 cm, executed", primo("study", "diff", self.home, self.home))

    def test_config_dump_shows_the_study_with_its_includes(self):
        text = primo("config", "dump", "study", self.folder / "study.yaml")
        self.assertIn("name: study", text)
        self.assertIn("evaluations: 8", text)
        self.assertIn("generalization", primo("config", "keys", "study"))

    def test_wrong_files_and_directories_are_refused_with_what_would_be_right(self):
        (self.folder / "wrong.yaml").write_text("include: base.yaml\nname: wrong\ngeneralization: {levels: [0.01], seed: 1001}\n")
        self.assertIn("generalization.seed", primo("config", "dump", "study", self.folder / "wrong.yaml", code=78))
        self.assertIn("study.yaml", primo("study", "export", self.folder / "nowhere", code=78))
        self.assertIn("another study", primo("study", "run", self.folder / "study.yaml", "--local", "--directory", self.home,
                                             "--set", "seed=5", code=78))
        text = primo("study", "run", self.folder / "study.yaml", "--set", "optimizer.evaluatons=5", code=78)
        self.assertIn("evaluations", text)


if __name__ == "__main__":
    unittest.main()
