#!/usr/bin/env python3
"""The graph as a user handles it: up, status, a study, interrupted and gone on with, down with nothing left."""
import os
import pathlib
import re
import signal
import sqlite3
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).parent))
from running_graph import PATIENCE, ROOT, Graph, environment, free_domain, primo, wait_for  # noqa: E402

STUDY = pathlib.Path(__file__).parent / "small.yaml"
EXPECTED = ["camera", "conductor", "judge", "judge", "optimizer", "perception", "planner", "planner", "rule_learner"]


def shared_memory():
    return {p.name for p in pathlib.Path("/dev/shm").iterdir() if "fastrtps" in p.name}


def mapped(pid):
    """Names of the shared memory that a process has mapped."""
    text = pathlib.Path(f"/proc/{pid}/maps").read_text()
    return set(re.findall(r"/dev/shm/(fastrtps_\w+)", text))


def evaluations(directory):
    """The learning curve that a study's journal holds."""
    with sqlite3.connect(directory / "journal.db") as database:
        rows = database.execute("SELECT algorithm, restart, generation, candidate, gamma FROM evaluations ORDER BY 1, 2, 3, 4").fetchall()
    database.close()
    return rows


class Handled(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory(prefix="primo-study-")
        self.directory = pathlib.Path(self.folder.name) / "study"

    def tearDown(self):
        self.folder.cleanup()

    def test_status_shows_every_process_with_its_number(self):
        with Graph() as graph:
            workers = graph.status()
            self.assertEqual([w["role"] for w in workers], EXPECTED)
            self.assertEqual({w["name"]: w["pid"] for w in workers}, graph.processes())
            self.assertEqual({w["state"] for w in workers}, {"idle"})

    def test_with_any_number_of_workers_a_study_has_the_same_bytes(self):
        env = environment(self.directory.parent / "run", free_domain())
        local = self.directory.with_name("local")
        code, out, err = primo("study", "run", STUDY, "--local", "--no-report", "--directory", local, env=env)
        self.assertEqual(code, 0, out + err)
        for workers in (1, 3):
            with Graph(workers=workers) as graph:
                names = [w["role"] for w in graph.status()]
                self.assertEqual((names.count("planner"), names.count("judge")), (workers, workers))
                directory = self.directory.with_name(f"workers_{workers}")
                code, out, err = graph.primo("study", "run", STUDY, "--no-report", "--directory", directory)
                self.assertEqual(code, 0, out + err)
            self.assertEqual((directory / "result.json").read_bytes(), (local / "result.json").read_bytes())
            self.assertEqual(evaluations(directory), evaluations(local))

    def test_status_shows_a_process_that_hangs(self):
        with Graph() as graph:
            hung = max(pid for name, pid in graph.processes().items() if name.startswith("judge"))
            os.kill(hung, signal.SIGSTOP)
            silent = [w for w in graph.status() if w["state"] == "silent"]
            os.kill(hung, signal.SIGCONT)
            self.assertEqual([(w["role"], w["pid"]) for w in silent], [("judge", hung)])

    def test_down_leaves_no_process_and_nothing_in_shared_memory(self):
        graph = Graph()
        with graph:
            processes = graph.processes()
            self.assertEqual(len(processes), len(EXPECTED))
            used = {name for pid in processes.values() for name in mapped(pid)}
            self.assertGreaterEqual(len(used), len(EXPECTED))
        self.assertEqual(graph.processes(), {})
        self.assertEqual(used & shared_memory(), set())
        first = 7400 + 250 * int(graph.env["PRIMO_DOMAIN"])
        ports = {f"fastrtps_port{port}" for port in range(first, first + 250)}
        self.assertEqual(ports & shared_memory(), set())

    def test_down_stops_the_processes_of_a_killed_supervisor(self):
        graph = Graph()
        with graph:
            os.kill(int((graph.run / "supervisord.pid").read_text()), signal.SIGKILL)
            self.assertEqual(len(graph.processes()), len(EXPECTED))
        self.assertEqual(graph.processes(), {})

    def test_an_interrupted_study_goes_on_where_it_was(self):
        with Graph() as graph:
            running = graph.start_study(STUDY, self.directory)
            wait_for(lambda: (self.directory / "journal.db").exists(), "the study's first answer")
            running.send_signal(signal.SIGINT)
            out, err = running.communicate(timeout=PATIENCE)
            self.assertEqual(running.returncode, 130, out + err)
            self.assertIn("goes on from here", out)
            self.assertFalse((self.directory / "result.json").exists())

            code, out, err = graph.primo("study", "run", STUDY, "--directory", self.directory, "--no-report")
            self.assertEqual(code, 0, out + err)
            self.assertIn("goes on in", out)
            first = (self.directory / "result.json").read_bytes()

            code, out, err = graph.primo("study", "run", STUDY, "--directory", self.directory, "--no-report")
            self.assertEqual(code, 0, out + err)
            self.assertIn("is complete", out)

            code, out, err = graph.primo("study", "run", STUDY, "--directory", self.directory, "--no-report", "--new")
            self.assertEqual(code, 0, out + err)
            self.assertEqual((self.directory / "result.json").read_bytes(), first)
            aside = self.directory.parent / "study.1"
            self.assertEqual((aside / "result.json").read_bytes(), first)
            # The optimization was done again, and not answered by what was still latched from the first.
            self.assertGreaterEqual(len(evaluations(aside)), 100)
            self.assertEqual(evaluations(self.directory), evaluations(aside))

    def test_a_wrong_configuration_of_a_service_is_refused_before_anything_starts(self):
        graph = Graph()
        services = pathlib.Path(self.folder.name) / "services"
        for role in set(EXPECTED):
            (services / role).mkdir(parents=True)
            (services / role / f"{role}.yaml").write_text((ROOT / "services" / role / f"{role}.yaml").read_text())
        (services / "judge" / "judge.yaml").write_text("robott: configs/robots/schunk_lwa3_sdh2.yaml\n")
        graph.env["PRIMO_SERVICES"] = str(services)
        code, out, err = graph.primo("up")
        self.assertEqual(code, 78, out + err)
        self.assertEqual(len(err.strip().splitlines()), 1, err)
        self.assertIn("robott", err)
        self.assertIn("judge", err)
        self.assertEqual(graph.processes(), {})
        graph.close()

    def test_a_study_for_another_robot_than_the_graph_s_is_refused(self):
        with Graph() as graph:
            other = pathlib.Path(self.folder.name)
            for name in ("schunk_lwa3_sdh2.yaml", "schunk_lwa3_sdh2.xml"):
                (other / name).write_bytes((ROOT / "configs" / "robots" / name).read_bytes())
            code, out, err = graph.primo("study", "run", STUDY, "--directory", self.directory, "--set",
                                         f"robot={other / 'schunk_lwa3_sdh2.yaml'}")
            self.assertEqual(code, 78, out + err)
            self.assertIn("primo up --robot", err)
            self.assertFalse(self.directory.exists())


if __name__ == "__main__":
    unittest.main(verbosity=2)
