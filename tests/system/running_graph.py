"""A graph of services for one test: its own DDS domain, run-time folder and study directory; gone when the test is."""
import fcntl
import json
import os
import pathlib
import shutil
import signal
import subprocess
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
BIN = pathlib.Path(os.environ.get("PRIMO_BIN", ROOT / "build" / "release" / "bin"))
PRIMO = BIN / "primo"
# Jobs take milliseconds, the whole study seconds; this is for a machine that does much else.
PATIENCE = 60


def environment(run, domain):
    variables = {k: v for k, v in os.environ.items() if not k.startswith("PRIMO_")}
    variables.update(PRIMO_ROOT=str(ROOT), PRIMO_RUN=str(run), PRIMO_DOMAIN=str(domain))
    return variables


def primo(*arguments, env=None, timeout=PATIENCE):
    """Runs the command line; gives exit code, standard output, standard error."""
    finished = subprocess.run([str(PRIMO), *map(str, arguments)], env=env or os.environ, text=True,
                              capture_output=True, timeout=timeout)
    return finished.returncode, finished.stdout, finished.stderr


_held = []  # locks of the domains that this process has, until it ends


def free_domain():
    """A DDS domain that no other test of this machine is in; tests/test_domain.h takes its own in the same way."""
    for i in range(99):
        domain = 1 + (os.getpid() * 7 + i) % 99
        lock = open(f"/tmp/primo_test_domain_{domain}", "w")
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            lock.close()
            continue
        _held.append(lock)
        return domain
    raise AssertionError("no DDS domain is free")


def wait_for(condition, what, seconds=PATIENCE):
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        value = condition()
        if value:
            return value
        time.sleep(0.01)
    raise AssertionError(f"{what}: not within {seconds} s")


class Graph:
    """Context manager: `primo up` on entry, `primo down` on exit, and a check that nothing is left."""

    def __init__(self, workers=2):
        self.workers = workers
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="primo-"))
        self.run = self.folder / "run"
        self.env = environment(self.run, free_domain())

    def __enter__(self):
        code, out, err = primo("up", "--timeout", 60, "--workers", self.workers, env=self.env)
        if code != 0:
            logs = "\n".join(f"--- {p.name}\n{p.read_text()[-2000:]}" for p in sorted(self.run.glob("*.log")))
            self.close()
            raise AssertionError(f"primo up: {code}\n{out}{err}\n{logs}")
        return self

    def __exit__(self, *_):
        self.close()

    def close(self):
        code, out, err = primo("down", env=self.env)
        left = self.processes()
        for pid in left.values():
            os.kill(pid, signal.SIGKILL)
        shutil.rmtree(self.folder, ignore_errors=True)
        assert code == 0, out + err
        assert not left, f"left running: {left}"

    def primo(self, *arguments, **options):
        return primo(*arguments, env=self.env, **options)

    def start_study(self, file, directory, *arguments):
        return subprocess.Popen([str(PRIMO), "study", "run", str(file), "--directory", str(directory), "--no-report", *arguments],
                                env=self.env, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE)

    def status(self):
        code, out, err = self.primo("status", "--json")
        assert code == 0, err
        return json.loads(out)

    def report(self, lines=12):
        """What the graph says of itself: for who must find out why a test failed."""
        code, out, err = self.primo("status")
        logs = (f"--- {p.name}\n" + "\n".join(p.read_text(errors="replace").splitlines()[-lines:])
                for p in sorted(self.run.glob("*.log")))
        return "\n".join([out + err, *logs])

    def processes(self):
        """name → pid of this graph's services, as the kernel knows them."""
        found = {}
        for entry in pathlib.Path("/proc").iterdir():
            if not entry.name.isdigit():
                continue
            try:
                if not os.readlink(entry / "exe").startswith(f"{BIN}/primo_"):
                    continue
                if f"PRIMO_RUN={self.run}".encode() not in (entry / "environ").read_bytes().split(b"\0"):
                    continue
                words = (entry / "cmdline").read_bytes().decode().split("\0")
            except OSError:
                continue
            if "--name" not in words:  # it is just ending, and has no command line any more
                continue
            found[words[words.index("--name") + 1]] = int(entry.name)
        return found

    def kill(self, name):
        pid = self.processes().get(name)
        if pid is None:
            return None
        os.kill(pid, signal.SIGKILL)
        return pid
