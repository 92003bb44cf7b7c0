#!/usr/bin/env python3
"""Bad input to the command line and the services: one clear line, the right exit code, nothing half-written."""
import os
import pathlib
import re
import sqlite3
import subprocess
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).parent))
from running_graph import BIN, ROOT, environment, free_domain, primo  # noqa: E402

USAGE, UNAVAILABLE, CONFIGURATION = 64, 69, 78
EXAMPLE = ROOT / "configs" / "scenarios" / "example.yaml"
STUDY = pathlib.Path(__file__).parent / "small.yaml"
HERE = pathlib.Path(__file__).parent


class Refused(unittest.TestCase):
    def setUp(self):
        self.temporary = tempfile.TemporaryDirectory(prefix="primo-bad-")
        self.folder = pathlib.Path(self.temporary.name)
        self.env = environment(self.folder / "run", free_domain())

    def tearDown(self):
        self.temporary.cleanup()

    def refused(self, exit_code, words, *arguments):
        """The command ends with this code and says all of the words on one line of standard error."""
        code, out, err = primo(*arguments, env=self.env)
        self.assertEqual(code, exit_code, out + err)
        if exit_code != USAGE:
            self.assertEqual(len(err.strip().splitlines()), 1, err)
        for word in words:
            self.assertIn(word, err)

    def write(self, name, text):
        path = self.folder / name
        path.write_text(text)
        return path

    def scenario(self, old, new):
        text = EXAMPLE.read_text()
        self.assertIn(old, text)
        return self.write("scenario.yaml", text.replace(old, new))

    def study(self, old, new):
        text = STUDY.read_text().replace("../../", f"{ROOT}/").replace("crowded.yaml", f"{HERE}/crowded.yaml")
        self.assertIn(old, text)
        return self.write("study.yaml", text.replace(old, new))

    def test_an_unknown_verb(self):
        self.refused(USAGE, ["optimise"], "optimise")

    def test_a_missing_argument(self):
        self.refused(USAGE, ["file"], "scenario", "check")

    def test_an_unknown_key_with_its_line_and_the_nearest_known_one(self):
        self.refused(CONFIGURATION, ["scenario.yaml:", "'objects[2].half_extent'", "half_extents"], "scenario", "check",
                     self.scenario("half_extents", "half_extent"))

    def test_a_value_out_of_bounds(self):
        self.refused(CONFIGURATION, ["scenario.yaml", "9", "position"], "scenario", "check", self.scenario("0.80, 0.02", "9.80, 0.02"))

    def test_a_missing_file(self):
        self.refused(CONFIGURATION, ["nowhere.yaml"], "scenario", "check", self.folder / "nowhere.yaml")

    def test_overlapping_objects(self):
        self.refused(CONFIGURATION, ["c1", "c2"], "scenario", "check", self.scenario("0.93, 0.06", "0.83, 0.03"))

    def test_an_unreachable_object(self):
        far = self.scenario("name: example", "name: example\ntable: {top_centre: [2.4, 0.0, 0.67]}")
        text = far.read_text()
        for old, new in (("0.80, 0.02", "2.40, 0.02"), ("0.93, 0.06", "2.53, 0.06"), ("0.84, -0.15", "2.44, -0.15")):
            text = text.replace(old, new)
        far.write_text(text)
        self.refused(CONFIGURATION, ["c1", " m"], "scenario", "check", far)

    def test_an_object_beside_the_table(self):
        self.refused(CONFIGURATION, ["c2", "table"], "scenario", "check", self.scenario("0.93, 0.06", "1.30, 0.06"))

    def test_an_action_about_something_that_is_not_there(self):
        self.refused(CONFIGURATION, ["c9"], "scenario", "check", self.scenario("[grasp, c1]", "[grasp, c9]"))

    def test_a_robot_without_the_named_joint(self):
        robots = ROOT / "configs" / "robots"
        (self.folder / "schunk_lwa3_sdh2.xml").write_bytes((robots / "schunk_lwa3_sdh2.xml").read_bytes())
        text = (robots / "schunk_lwa3_sdh2.yaml").read_text()
        joint = re.search(r"joint: (\w+)", text).group(1)
        robot = self.write("robot.yaml", text.replace(f"joint: {joint}", "joint: elbow_of_nobody", 1))
        self.refused(CONFIGURATION, ["elbow_of_nobody", joint.rstrip("0123456789")], "rollout", EXAMPLE, "--robot", robot)

    def test_a_study_whose_scenario_is_missing(self):
        self.refused(CONFIGURATION, ["gone.yaml"], "study", "run", self.study("crowded.yaml", "gone.yaml"), "--local",
                     "--directory", self.folder / "study")
        self.assertFalse((self.folder / "study").exists())

    def test_an_unknown_optimizer(self):
        self.refused(CONFIGURATION, ["simulated_annealing", "cma"], "study", "run", self.study("[cma]", "[simulated_annealing]"),
                     "--local", "--directory", self.folder / "study")

    def test_a_directory_of_another_study(self):
        directory = self.folder / "study"
        directory.mkdir()
        self.run_tiny_study(directory)
        before = {p.name: p.read_bytes() for p in directory.iterdir() if p.suffix == ".yaml"}
        self.refused(CONFIGURATION, ["another study", "--new"], "study", "run", STUDY, "--local", "--directory", directory)
        self.assertEqual({p.name: p.read_bytes() for p in directory.iterdir() if p.suffix == ".yaml"}, before)

    TINY = ("--set", "experience.scenarios=4", "--set", "executed=0", "--set", "optimizer.evaluations=8")

    def run_tiny_study(self, directory):
        code, out, err = primo("study", "run", STUDY, "--local", "--directory", directory, "--no-report", *self.TINY, env=self.env)
        self.assertEqual(code, 0, out + err)

    def corrupt_journal(self, damage, words):
        directory = self.folder / "study"
        self.run_tiny_study(directory)
        journal = directory / "journal.db"
        (directory / "result.json").unlink(missing_ok=True)
        for rest in ("journal.db-wal", "journal.db-shm"):
            (directory / rest).unlink(missing_ok=True)
        damage(journal)
        damaged = journal.read_bytes()
        self.refused(CONFIGURATION, ["journal.db", *words], "study", "run", STUDY, "--local", "--directory", directory, "--no-report", *self.TINY)
        self.assertEqual(journal.read_bytes(), damaged, "a journal that is refused is left as it is")

    def test_a_journal_that_is_none(self):
        self.corrupt_journal(lambda journal: journal.write_bytes(b"not a journal at all " * 400), [])

    def test_a_journal_of_another_format(self):
        def damage(journal):
            with sqlite3.connect(journal) as database:
                database.execute("PRAGMA user_version = 99")
            database.close()
        self.corrupt_journal(damage, ["99"])

    def test_a_study_without_a_graph(self):
        self.refused(UNAVAILABLE, ["primo up", "--local"], "study", "run", STUDY, "--directory", self.folder / "study")
        self.assertFalse((self.folder / "study").exists())

    def test_status_without_a_graph(self):
        self.refused(UNAVAILABLE, ["primo up"], "status")

    def test_a_domain_that_is_none(self):
        self.env["PRIMO_DOMAIN"] = "three"
        self.refused(CONFIGURATION, ["PRIMO_DOMAIN", "three", "232"], "status")

    def test_experiences_that_are_none(self):
        lines = self.write("experience.jsonl", '{"objects":["c1"],"s":[],"a":["grasp","c1"],"s2":[]}\n{"objects":\n')
        self.refused(CONFIGURATION, ["experience.jsonl:2"], "rules", "learn", "--experiences", lines)

    def test_a_plan_for_another_robot(self):
        plan = self.write("plan.json", '{"trajectory": {"joints": ["a"], "dt": 0.1, "q": [[0.0]]}}')
        self.refused(CONFIGURATION, ["plan.json", "joints"], "judge", EXAMPLE, plan)

    def test_a_service_with_a_bad_option_or_key(self):
        def service(*arguments):
            finished = subprocess.run([BIN / "primo_judge", *arguments], env=self.env, text=True, capture_output=True, timeout=30)
            return finished.returncode, finished.stderr
        self.assertEqual(service("--nonsense")[0], USAGE)
        code, err = service("--config", str(self.write("judge.yaml", "robot: x\nspeed: 3\n")))
        self.assertEqual(code, CONFIGURATION, err)
        self.assertIn("judge.yaml:2", err)
        code, err = service("--config", str(self.folder / "nowhere.yaml"))
        self.assertEqual(code, CONFIGURATION, err)


if __name__ == "__main__":
    unittest.main(verbosity=2)
