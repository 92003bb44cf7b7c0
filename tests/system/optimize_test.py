"""primo optimize: what it prints, that it goes on from its checkpoint bit for bit after being killed, and what it refuses."""
import json
import pathlib
import signal
import subprocess
import tempfile
import time
import unittest

from running_graph import BIN, primo

FUNCTIONS = {
    "sphere": lambda x: sum(v * v for v in x),
    "ellipsoid": lambda x: sum(10 ** (6 * i / (len(x) - 1)) * v * v for i, v in enumerate(x)),
    "rosenbrock": lambda x: sum(100 * (b - a * a) ** 2 + (1 - a) ** 2 for a, b in zip(x, x[1:])),
}


class Optimize(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="primo-optimize-")
        self.addCleanup(folder.cleanup)
        self.file = pathlib.Path(folder.name) / "state.json"

    def ask(self, *arguments):
        code, out, err = primo("optimize", *arguments, "--json")
        self.assertEqual(code, 0, out + err)
        self.assertEqual(len(out.splitlines()), 1, out)
        return json.loads(out)

    def refuse(self, code, word, *arguments):
        got, out, err = primo("optimize", *arguments, "--json")
        self.assertEqual(got, code, out + err)
        self.assertIn(word, err)
        self.assertEqual(len(err.strip().splitlines()), 1, err)
        self.assertEqual(out, "")

    def test_prints_what_it_found(self):
        for name, cost in FUNCTIONS.items():
            found = self.ask("--problem", name, "--dim", 6, "--optimizer", "cma", "--seed", 3, "--target", 1e-8)
            self.assertEqual((found["stop"], found["restarts"]), ("target", 0))
            self.assertLessEqual(found["best"], 1e-8)
            self.assertEqual(len(found["x"]), 6)
            self.assertAlmostEqual(cost(found["x"]), found["best"], delta=1e-12)
            self.assertLess(found["evaluations"], 5000)

    def test_every_optimizer_spends_its_budget_and_not_more(self):
        for name in ("cma", "monte_carlo", "sobol", "differential_evolution"):
            found = self.ask("--problem", "rastrigin", "--dim", 3, "--optimizer", name, "--max-evaluations", 500)
            self.assertEqual(found["stop"], "budget")
            self.assertLessEqual(found["evaluations"], 500)
            self.assertGreater(found["evaluations"], 450)

    def test_goes_on_where_a_smaller_budget_ended(self):
        task = ("--problem", "rosenbrock", "--dim", 5, "--seed", 8)
        for name in ("cma", "monte_carlo", "sobol", "differential_evolution"):
            whole = self.ask(*task, "--optimizer", name, "--max-evaluations", 1000)
            file = self.file.with_name(name)
            for budget in (100, 333, 1000, 1000):
                last = self.ask(*task, "--optimizer", name, "--max-evaluations", budget, "--checkpoint", file)
            self.assertEqual(last, whole)

    def test_killed_at_any_moment_ends_with_the_same_bytes(self):
        task = [str(a) for a in ("optimize", "--problem", "ellipsoid", "--dim", 20, "--seed", 5, "--max-evaluations", 6000, "--json")]
        whole = subprocess.run([BIN / "primo", *task], capture_output=True, check=True).stdout
        kills = 0
        for attempt in range(200):
            process = subprocess.Popen([BIN / "primo", *task, "--checkpoint", self.file], stdout=subprocess.PIPE)
            try:
                out, _ = process.communicate(timeout=0.05 + 0.03 * (attempt % 7))
                self.assertEqual(process.returncode, 0)
                break
            except subprocess.TimeoutExpired:
                process.send_signal(signal.SIGKILL)
                process.communicate()
                kills += 1
                if self.file.exists():
                    json.loads(self.file.read_text())  # never half a file
        else:
            # A machine that is too slow to come anywhere between two kills is let finish.
            out = subprocess.run([BIN / "primo", *task, "--checkpoint", self.file], capture_output=True, check=True).stdout
        self.assertGreater(kills, 0)
        self.assertEqual(out, whole)

    def test_an_interrupt_leaves_a_checkpoint_to_go_on_from(self):
        task = ("--problem", "ellipsoid", "--dim", 30, "--seed", 2, "--max-evaluations", 9000, "--checkpoint", self.file)
        process = subprocess.Popen([BIN / "primo", "optimize", *map(str, task), "--json"], stdout=subprocess.PIPE, text=True)
        while not self.file.exists() and process.poll() is None:
            time.sleep(0.01)
        process.send_signal(signal.SIGINT)
        out, _ = process.communicate(timeout=60)
        if process.returncode != 0:  # else it was faster than the signal
            self.assertEqual(process.returncode, 130)
            self.assertEqual(json.loads(out)["stop"], "interrupted")
        self.assertEqual(self.ask(*task), self.ask(*task[:-2]))

    def test_refuses_what_makes_no_sense_and_leaves_the_checkpoint_alone(self):
        self.refuse(64, "known: sphere, ellipsoid", "--problem", "spher")
        self.refuse(78, "known: cma, monte_carlo", "--problem", "sphere", "--optimizer", "annealing")
        self.refuse(78, "below one generation of 10", "--problem", "sphere", "--max-evaluations", 9)
        self.refuse(78, "the lower below the upper", "--problem", "sphere", "--lower", 2, "--upper", -2)
        self.refuse(78, "must be finite", "--problem", "sphere", "--lower", "nan")
        self.refuse(78, "it must be ipop, bipop, again or stop", "--problem", "sphere", "--on-stagnation", "never")
        self.ask("--problem", "sphere", "--max-evaluations", 100, "--checkpoint", self.file)
        before = self.file.read_bytes()
        here = ("--max-evaluations", 100, "--checkpoint", self.file)
        self.refuse(78, "another problem: its 'problem' is \"sphere\", here it is \"ellipsoid\"", "--problem", "ellipsoid", *here)
        self.refuse(78, "another problem: its 'lower'", "--problem", "sphere", "--dim", 5, *here)
        self.refuse(78, "another problem: its 'seed'", "--problem", "sphere", "--seed", 2, *here)
        self.assertEqual(self.file.read_bytes(), before)
        self.file.write_bytes(before[: len(before) // 2])
        self.refuse(78, "half a file", "--problem", "sphere", *here)
        self.assertEqual(self.file.read_bytes(), before[: len(before) // 2])
        self.refuse(1, "cannot be written", "--problem", "sphere", "--max-evaluations", 100, "--checkpoint", "/nonexistent/state")


if __name__ == "__main__":
    unittest.main()
