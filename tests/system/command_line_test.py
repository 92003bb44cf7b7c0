"""What other programs rely on: primo plan, judge and rollout print one JSON object with these keys, and write these files."""
import json
import pathlib
import tempfile
import unittest

from running_graph import ROOT, primo

ROBOT = ROOT / "configs/robots/schunk_lwa3_sdh2.yaml"
SCENARIO = ROOT / "configs/scenarios/grasp_1.yaml"
PRIMITIVE = ROOT / "configs/primitives/grasp_reference.yaml"
WHERE = ("--robot", ROBOT, "--scenario", SCENARIO)


class CommandLine(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="primo-command-line-")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def ask(self, *arguments):
        code, out, err = primo(*arguments, "--json")
        self.assertEqual(code, 0, out + err)
        self.assertEqual(len(out.splitlines()), 1, out)
        return json.loads(out)

    def plan(self, *arguments):
        return self.ask("plan", *WHERE, "--primitive", PRIMITIVE, *arguments)

    def test_plan_reports_cost_and_measures_and_writes_the_trajectory_with_its_gains(self):
        file = self.folder / "trajectory.json"
        report = self.plan("--seed", 3, "--out", file)
        self.assertIn(report["status"], ("converged_step", "converged_cost"))
        self.assertTrue(report["reason"])
        for key in ("iterations", "rejected", "gradient_norm", "time_ms", "min_distance_m", "min_limit_margin_rad", "path_length_rad"):
            self.assertIsInstance(report[key], (int, float), key)
        cost = report["cost"]
        self.assertLess(cost["final"], cost["initial"])
        self.assertAlmostEqual(cost["control"] + sum(cost["tasks"].values()), cost["final"], places=9)
        trajectory = json.loads(file.read_text())
        n, T = len(trajectory["joints"]), len(trajectory["q"]) - 1
        self.assertEqual((n, T, trajectory["dt"]), (14, 64, 4 / 64))
        self.assertEqual([len(row) for row in trajectory["q"]], [n] * (T + 1))
        gains = trajectory["gains"]["K"]
        self.assertEqual((len(gains), len(gains[0]), len(gains[0][0])), (T, n, 2 * n))
        length = sum(sum((b - a) ** 2 for a, b in zip(p, q)) ** 0.5 for p, q in zip(trajectory["q"], trajectory["q"][1:]))
        self.assertAlmostEqual(report["path_length_rad"], length, places=9)

    def test_plan_is_the_same_again_but_for_its_time_and_takes_options_for_the_primitive_s(self):
        first, again = self.plan("--seed", 4), self.plan("--seed", 4)
        for report in (first, again):
            del report["time_ms"]
        self.assertEqual(first, again)
        few = self.plan("--seed", 4, "--max-iterations", 2, "--start", "rest", "--solver", "gauss_newton")
        self.assertEqual((few["status"], few["start"]), ("iteration_limit", "rest"))
        self.assertEqual(few["iterations"] + few["rejected"], 2)

    def test_a_picture_of_the_motion_is_drawn(self):
        picture = self.folder / "motion.png"
        self.plan("--png", picture)
        self.assertEqual(picture.read_bytes()[:8], b"\x89PNG\r\n\x1a\n")
        self.assertGreater(picture.stat().st_size, 10000)

    def test_judge_tells_the_verdict_on_a_trajectory_file(self):
        file = self.folder / "trajectory.json"
        self.plan("--out", file)
        for mode in ("final_pose", "execute"):
            verdict = self.ask("judge", *WHERE, "--trajectory", file, "--seed", 7, "--mode", mode)
            self.assertIs(verdict["success"], True, verdict)
            self.assertIn("on(c1,table)", verdict["symbols_before"])
            self.assertIn("inhand(c1)", verdict["symbols_after"])
            self.assertLess(verdict["displacement_m"], 0.04)
            self.assertGreater(verdict["steps"], 100)
            self.assertGreater(verdict["time_ms"], 0)
            for criterion in verdict["criteria"]:
                self.assertEqual(set(criterion), {"name", "value", "margin", "indicator"})
                self.assertIn(criterion["indicator"], (0, 1))

    def test_rollout_gives_both_reports(self):
        both = self.ask("rollout", *WHERE, "--primitive", PRIMITIVE, "--seed", 7)
        self.assertIs(both["verdict"]["success"], True)
        self.assertGreater(both["plan"]["iterations"], 0)

    def test_what_is_wrong_with_a_trajectory_is_said_with_its_key(self):
        file = self.folder / "trajectory.json"
        self.plan("--out", file)
        good = json.loads(file.read_text())
        for change, said in (
            ({"joints": good["joints"][:-1]}, "'q[0]' must have 13 numbers"),
            ({"joints": good["joints"][::-1]}, "not those of"),
            ({"q": [[0.0] * 13] * 65}, "'q[0]' must have 14 numbers"),
            ({"q": good["q"][:2] + [["x"] * 14]}, "'q[2]' must hold numbers"),
            ({"q": []}, "'q' must be a list of rows"),
            ({"dt": "slow"}, "'dt'"),
            ({"gains": {"K": [[[0.0] * 28] * 14]}}, "'gains.K' must have one matrix a step, 64"),
        ):
            file.write_text(json.dumps({**good, **change}))
            code, out, err = primo("judge", *WHERE, "--trajectory", file)
            self.assertEqual((code, out), (78, ""), err)
            self.assertIn(said, err)
            self.assertEqual(len(err.splitlines()), 1, err)

    def test_names_that_do_not_exist_are_refused_with_those_that_do(self):
        for arguments in (("--solver", "magic"), ("--start", "luck")):
            code, _, err = primo("plan", *WHERE, *arguments)
            self.assertEqual(code, 64, err)
            self.assertTrue("gauss_newton" in err or "rest" in err, err)


if __name__ == "__main__":
    unittest.main(verbosity=2)
