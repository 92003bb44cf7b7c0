#!/usr/bin/env python3
"""Each process of the graph, killed in the middle of a study: the study ends by itself, and with the same bytes."""
import os
import pathlib
import signal
import sqlite3
import sys
import tempfile
import time
import unittest

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).parent))
from running_graph import PATIENCE, Graph, environment, free_domain, primo, wait_for  # noqa: E402

STUDY = pathlib.Path(__file__).parent / "small.yaml"
SCENES = 18  # what the study observes


class Journal:
    """How far a study is, read from the journal while others write it."""

    def __init__(self, directory):
        self.file = directory / "journal.db"

    def _count(self, query):
        if not self.file.exists():
            return 0
        try:
            with sqlite3.connect(f"file:{self.file}?mode=ro", uri=True, timeout=0.05) as database:
                return database.execute(query).fetchone()[0]
        except sqlite3.OperationalError:  # no tables yet, or locked just now
            return 0

    def answers(self, kind):
        return self._count(f"SELECT count(*) FROM answers WHERE kind = '{kind}'")

    def evaluations(self):
        return self._count("SELECT count(*) FROM evaluations")


class EndedBeforeTheKill(Exception):
    """The study was quicker than the test: it proves nothing and is run again."""


class Killed(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory(prefix="primo-kill-")
        cls.root = pathlib.Path(cls.folder.name)
        env = environment(cls.root / "run", free_domain())
        code, out, err = primo("study", "run", STUDY, "--local", "--no-report", "--directory", cls.root / "local", env=env)
        assert code == 0, out + err
        cls.expected = (cls.root / "local" / "result.json").read_bytes()
        cls.graph = Graph()
        cls.graph.__enter__()

    @classmethod
    def tearDownClass(cls):
        cls.graph.close()
        cls.folder.cleanup()

    def study(self, disturb=None):
        """Runs the study in the graph; `disturb(journal, running)` does its worst meanwhile."""
        for attempt in range(4):
            try:
                return self.run_study(disturb, self.root / f"{self.id().rsplit('.', 1)[-1]}_{attempt}")
            except EndedBeforeTheKill:
                pass
        self.fail("the study ended before the kill, four times")

    def run_study(self, disturb, directory):
        running = self.graph.start_study(STUDY, directory)
        try:
            if disturb:
                disturb(Journal(directory), running)
            out, err = running.communicate(timeout=PATIENCE)
        except EndedBeforeTheKill:
            running.communicate()
            raise
        except BaseException:
            running.kill()
            out, err = running.communicate()
            print(f"{directory.name}:\n{out}{err}\n{self.graph.report()}", file=sys.stderr)
            raise
        self.assertEqual(running.returncode, 0, out + err)
        self.assertEqual((directory / "result.json").read_bytes(), self.expected)

    def kill(self, name, running, hold=0.0):
        """SIGKILL; with `hold` after a time of SIGSTOP, in which it surely gets work that it does not answer."""
        if running.poll() is not None:
            raise EndedBeforeTheKill
        pid = self.graph.processes()[name]
        if hold:
            os.kill(pid, signal.SIGSTOP)
            time.sleep(hold)
        os.kill(pid, signal.SIGKILL)
        wait_for(lambda: self.graph.processes().get(name, pid) != pid, f"{name} started again", 20)

    def kill_when(self, name, reached, hold=0.0):
        def disturb(journal, running):
            wait_for(lambda: running.poll() is not None or reached(journal), f"the study before the kill of {name}")
            self.kill(name, running, hold)
        self.study(disturb)

    def test_undisturbed_the_graph_finds_what_one_process_finds(self):
        self.study()

    def test_camera(self):
        self.kill_when("camera", lambda journal: 0 < journal.answers("observe") < SCENES, hold=0.2)

    def test_perception(self):
        self.kill_when("perception", lambda journal: 0 < journal.answers("observe") < SCENES, hold=0.2)

    def test_planner(self):
        self.kill_when("planner-1", lambda journal: journal.answers("rollout") > 2, hold=0.2)

    def test_judge(self):
        self.kill_when("judge-2", lambda journal: journal.answers("rollout") > 2, hold=0.2)

    def test_both_planners_one_after_the_other(self):
        def disturb(journal, running):
            wait_for(lambda: journal.evaluations() > 0 or running.poll() is not None, "the optimization")
            self.kill("planner-1", running)
            self.kill("planner-2", running)
        self.study(disturb)

    def test_rule_learner_with_a_batch_in_hand(self):
        def disturb(journal, running):
            pid = self.graph.processes()["rule_learner"]
            os.kill(pid, signal.SIGSTOP)
            wait_for(lambda: journal.answers("rollout") >= 20 or running.poll() is not None, "the first collection")
            time.sleep(0.5)
            self.assertEqual(journal.answers("learn"), 0)
            self.kill("rule_learner", running)
        self.study(disturb)

    def test_optimizer(self):
        self.kill_when("optimizer", lambda journal: journal.evaluations() >= 8)

    def test_conductor_while_it_collects(self):
        self.kill_when("conductor", lambda journal: 0 < journal.answers("rollout") < 20)

    def test_conductor_while_the_optimizer_works(self):
        self.kill_when("conductor", lambda journal: journal.evaluations() >= 8)

    # As on a machine that has other things to do: longer than a death takes to be noticed, and than Fast DDS waits.
    def test_stalled_for_seconds_but_not_killed(self):
        def disturb(journal, running):
            for names in (["conductor", "judge-1"], ["camera", "optimizer", "planner-2"], list(self.graph.processes())):
                wait_for(lambda: journal.answers("rollout") > 2 or running.poll() is not None, "the first collection")
                if running.poll() is not None:
                    raise EndedBeforeTheKill
                pids = [self.graph.processes()[name] for name in names]
                for pid in pids:
                    os.kill(pid, signal.SIGSTOP)
                time.sleep(4)
                for pid in pids:
                    os.kill(pid, signal.SIGCONT)
        self.study(disturb)

    def test_conductor_and_optimizer_together(self):
        def disturb(journal, running):
            wait_for(lambda: journal.evaluations() >= 8 or running.poll() is not None, "the optimization")
            if running.poll() is not None:
                raise EndedBeforeTheKill
            for name in ("conductor", "optimizer"):
                os.kill(self.graph.processes()[name], signal.SIGKILL)
        self.study(disturb)


if __name__ == "__main__":
    unittest.main(verbosity=2)
