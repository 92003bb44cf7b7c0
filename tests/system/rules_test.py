"""primo rules: the command line's contract, and that the exported PPDDL means what the rules predict."""
import itertools
import json
import pathlib
import random
import tempfile
import unittest

from running_graph import primo


# --- a small interpreter of the PPDDL that is exported -----------------------------------------------------------------
def parse(text):
    tokens = "\n".join(line.split(";")[0] for line in text.splitlines()).replace("(", " ( ").replace(")", " ) ").split()

    def read():
        token = tokens.pop(0)
        if token != "(":
            return token
        items = []
        while tokens[0] != ")":
            items.append(read())
        tokens.pop(0)
        return items

    return read()


class Domain:
    def __init__(self, text):
        self.actions, self.axioms, self.functions = {}, [], set()
        for item in parse(text)[2:]:
            if item[0] == ":action":
                self.actions[item[1]] = {key: value for key, value in zip(item[2::2], item[3::2])}
            elif item[0] == ":derived":
                self.axioms.append((item[1], item[2]))
            elif item[0] == ":functions":
                self.functions = {f[0] for f in item[1:]}

    def holds(self, formula, state, objects, binding):
        if not formula or formula[0] == "and":
            return all(self.holds(part, state, objects, binding) for part in formula[1:])
        head = formula[0]
        if head == "or":
            return any(self.holds(part, state, objects, binding) for part in formula[1:])
        if head == "not":
            return not self.holds(formula[1], state, objects, binding)
        if head == "imply":
            return not self.holds(formula[1], state, objects, binding) or self.holds(formula[2], state, objects, binding)
        if head in ("exists", "forall"):
            each = (self.holds(formula[2], state, objects, {**binding, **dict(zip(formula[1], values))})
                    for values in itertools.product(objects, repeat=len(formula[1])))
            return any(each) if head == "exists" else all(each)
        if head in ("=", ">=", "<="):
            if isinstance(formula[1], list):
                value = state.get(self.ground(formula[1], binding))
                bound = int(formula[2])
                return value is not None and {"=": value == bound, ">=": value >= bound, "<=": value <= bound}[head]
            return binding.get(formula[1], formula[1]) == binding.get(formula[2], formula[2])
        return self.ground(formula, binding) in state

    @staticmethod
    def ground(atom, binding):
        return (atom[0], *(binding.get(term, term) for term in atom[1:]))

    def with_axioms(self, state, objects):
        state = dict(state)
        while True:
            size = len(state)
            for head, body in self.axioms:
                for values in itertools.product(objects, repeat=len(head) - 1):
                    binding = dict(zip(head[1:], values))
                    if self.holds(body, state, objects, binding):
                        state[self.ground(head, binding)] = True
            if len(state) == size:
                return state

    def effects(self, effect, state, objects, binding):
        """(probability, changes) pairs: changes is a frozenset of (atom, value), value None for a deleted atom."""
        head = effect[0] if effect else "and"
        if head == "and":
            choices = [(1.0, frozenset())]
            for part in effect[1:]:
                choices = [(p * q, a | b) for p, a in choices for q, b in self.effects(part, state, objects, binding)]
            return choices
        if head == "when":
            return self.effects(effect[2], state, objects, binding) if self.holds(effect[1], state, objects, binding) \
                else [(1.0, frozenset())]
        if head == "forall":
            return self.effects(["and"] + [self.substituted(effect[2], dict(zip(effect[1], values)))
                                           for values in itertools.product(objects, repeat=len(effect[1]))],
                                state, objects, binding)
        if head == "probabilistic":
            choices, rest = [], 1.0
            for p, part in zip(effect[1::2], effect[2::2]):
                rest -= float(p)
                choices += [(float(p) * q, a) for q, a in self.effects(part, state, objects, binding)]
            return choices + [(rest, frozenset())]
        if head == "not":
            return [(1.0, frozenset([(self.ground(effect[1], binding), None)]))]
        if head == "assign":
            return [(1.0, frozenset([(self.ground(effect[1], binding), int(effect[2]))]))]
        return [(1.0, frozenset([(self.ground(effect, binding), True)]))]

    def substituted(self, tree, binding):
        return [self.substituted(part, binding) for part in tree] if isinstance(tree, list) else binding.get(tree, tree)

    def successors(self, action, state, objects):
        known = self.actions[action[0]]
        binding = dict(zip(known[":parameters"], action[1:]))
        full = self.with_axioms(state, objects)
        if not self.holds(known[":precondition"], full, objects, binding):
            return {}
        result = {}
        for p, changes in self.effects(known[":effect"], full, objects, binding):
            if p < 1e-12:
                continue
            after = dict(state)
            for atom, value in changes:
                if value is None:
                    after.pop(atom, None)
            for atom, value in changes:
                if value is not None:
                    after[atom] = value
            key = frozenset(after.items())
            result[key] = result.get(key, 0) + p
        return result


def as_state(literals):
    state = {}
    for literal in literals:
        if isinstance(literal[-1], int):
            state[tuple(literal[:-1])] = literal[-1]
        else:
            state[tuple(literal)] = True
    return state


RULES = {
    "rules": [
        {"action": ["puton", "X"], "context": [["clear", "X"], ["inhand", "Y"], ["table", "T"], ["not", "top", "T"]],
         "outcomes": [[0.7, [["on", "Y", "X"], ["not", "inhand", "Y"], ["not", "clear", "X"]]],
                      [0.2, [["on", "Y", "T"], ["not", "inhand", "Y"]]]], "noise": 0.1},
        {"action": ["puton", "X"], "context": [["table", "X"], ["inhand", "Y"], [">=", "weight", "Y", 2]],
         "outcomes": [[0.5, [["on", "Y", "X"], ["weight", "Y", 1]]], [0.5, [["on", "Y", "X"], ["not", "inhand", "Y"]]]],
         "noise": 0},
        {"action": ["puton", "X"], "context": [["wet"], ["inhand", "Y"], ["on", "X", "Z"], ["table", "Z"]],
         "outcomes": [[0.4, [["on", "Y", "Z"]]], [0.6, []]], "noise": 0},
        {"action": ["join", "X", "X"], "context": [["clear", "X"]], "outcomes": [[1, [["wet"]]]], "noise": 0},
        {"action": ["join", "X", "Y"], "context": [["above", "X", "Y"]], "outcomes": [[0.3, [["not", "wet"]]], [0.7, []]],
         "noise": 0}],
    "default": {"puton": {"nochange": 0.8, "noise": 0.2}, "join": {"nochange": 1, "noise": 0}},
    "derived": ["above(X,Y) := closure on(X,Y)", "top(X) := exists Y: on(X,Y) and not exists Z: on(Z,X)"]}


def draw_situation(rng):
    objects = ["a", "b", "c", "t"]
    s = [["table", "t"]] + [["clear", o] for o in objects if rng.random() < 0.6]
    s += [["on", x, y] for x in objects for y in objects if x != y and rng.random() < 0.15]
    s += [["inhand", o] for o in "abc" if rng.random() < 0.35]
    s += [["weight", o, rng.randint(0, 3)] for o in objects if rng.random() < 0.8]
    s += [["wet"]] if rng.random() < 0.5 else []
    action = ["puton", rng.choice(objects)] if rng.random() < 0.7 else ["join", rng.choice(objects), rng.choice(objects)]
    return {"objects": objects, "s": s, "a": action, "s2": s}


def grasps(n, seed):
    """Grasping works in nine of ten cases for what stands on a table and is no box."""
    rng = random.Random(seed)
    lines = []
    for _ in range(n):
        s = [["table", "t"], ["on", "c", "t" if rng.random() < 0.7 else "d"], ["on", "d", "t"]]
        s += [["box", "c"]] if rng.random() < 0.3 else []
        works = ["on", "c", "t"] in s and ["box", "c"] not in s and rng.random() < 0.9
        after = [l for l in s if l[:2] != ["on", "c"]] + [["inhand", "c"]] if works else s
        lines.append(json.dumps({"objects": ["c", "d", "t"], "s": s, "a": ["grasp", "c"], "s2": after}))
    return lines


class RulesCommandLine(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="primo-rules-")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def file(self, name, content):
        path = self.folder / name
        path.write_text(content if isinstance(content, str) else json.dumps(content))
        return path

    def run_primo(self, *arguments):
        code, out, err = primo("rules", *arguments)
        self.assertEqual(code, 0, out + err)
        return out, err

    def test_learned_rules_predict_and_score_as_the_contract_says(self):
        data = self.file("data.jsonl", "\n".join(grasps(200, 1)) + "\n")
        rules = self.folder / "R.json"
        self.run_primo("learn", "--experiences", data, "--alpha", 0.5, "--p-min", 1e-8, "--seed", 3, "--out", rules)
        learned = json.loads(rules.read_text())
        self.assertEqual(len(learned["rules"]), 1, learned)
        rule = learned["rules"][0]
        self.assertEqual({tuple(l) for l in rule["context"]}, {("on", "X", "Y"), ("table", "Y"), ("not", "box", "X")})
        self.assertEqual(sum(rule["counts"]), sum(1 for l in grasps(200, 1)
                                                  if '["on", "c", "t"]' in l.split('"a"')[0] and "box" not in l))
        out, _ = self.run_primo("predict", "--rules", rules, "--experiences", data)
        lines = out.splitlines()
        self.assertEqual(len(lines), 200)
        log_likelihood = 0
        for line, experience in zip(lines, grasps(200, 1)):
            prediction = json.loads(line)
            self.assertEqual(set(prediction), {"successors", "noise"})
            total = sum(p for _, p in prediction["successors"]) + prediction["noise"]
            self.assertAlmostEqual(total, 1)
            after = as_state(json.loads(experience)["s2"])
            p = 1e-8 * prediction["noise"] + sum(q for state, q in prediction["successors"] if as_state(state) == after)
            log_likelihood += __import__("math").log(p)
        out, _ = self.run_primo("score", "--rules", rules, "--experiences", data)
        score = json.loads(out)
        self.assertEqual(set(score), {"log_likelihood", "penalty", "score"})
        literals = len(rule["context"]) + sum(len(outcome) for _, outcome in rule["outcomes"])
        self.assertEqual(score["penalty"], literals)
        self.assertAlmostEqual(score["log_likelihood"], log_likelihood, places=6)
        self.assertAlmostEqual(score["score"], log_likelihood - 0.5 * literals, places=6)
        out, _ = self.run_primo("score", "--rules", rules, "--experiences", data, "--alpha", 2)
        self.assertAlmostEqual(json.loads(out)["score"], log_likelihood - 2 * literals, places=6)

    def test_seeds_and_the_order_of_lines_change_nothing(self):
        lines = grasps(120, 2)
        first = self.run_primo("learn", "--experiences", self.file("a", "\n".join(lines)), "--seed", 1, "--json")
        again = self.run_primo("learn", "--experiences", self.file("b", "\n".join(lines[::-1])), "--seed", 2, "--json")
        self.assertEqual(first, again)

    def test_unusual_data_is_fine(self):
        out, err = self.run_primo("learn", "--experiences", self.file("empty", ""), "--out", self.folder / "R.json")
        self.assertIn("no experience", err)
        self.assertEqual(json.loads((self.folder / "R.json").read_text()), {"rules": [], "default": {}})
        odd = [{"objects": [], "s": [], "a": ["wait"], "s2": []},
               {"objects": ["x"], "s": [["wait", "x"]], "a": ["wait"], "s2": []},
               {"objects": ["x", "y"], "s": [], "a": ["make", "x", "x"], "s2": [["part", "y"]]}]
        out, _ = self.run_primo("learn", "--experiences", self.file("odd", "\n".join(map(json.dumps, odd))), "--json")
        self.assertEqual(set(json.loads(out)["default"]), {"wait", "make"})

    def test_bad_input_is_named_or_counted(self):
        data = self.file("bad.jsonl", grasps(1, 1)[0] + "\n{\"objects\": [\n" + grasps(1, 2)[0] + "\n")
        code, out, err = primo("rules", "learn", "--experiences", data)
        self.assertEqual((code, out), (78, ""))
        self.assertIn("bad.jsonl:2: not JSON", err)
        self.assertEqual(len(err.splitlines()), 1, err)
        _, err = self.run_primo("learn", "--experiences", data, "--skip-bad")
        self.assertIn("1 lines skipped, 2 used", err)
        arity = self.file("arity.jsonl", grasps(1, 1)[0] + '\n{"objects":["c"],"s":[["on","c"]],"a":["grasp","c"],"s2":[]}\n')
        code, _, err = primo("rules", "learn", "--experiences", arity)
        self.assertEqual(code, 78)
        self.assertIn("arity.jsonl:2: on has 1 argument, but 2 in", err)
        for content, said in (({"rules": [{"action": ["a"]}]}, "rules[0]: lacks the key \"context\""),
                              ({"rules": [], "derived": ["a(X) = b"]}, "derived[0]: character"),
                              ({"rulez": []}, "unknown key")):
            code, _, err = primo("rules", "show", self.file("R.json", content))
            self.assertEqual(code, 78)
            self.assertIn(said, err)
        rules = self.file("R.json", RULES)
        other = self.file("other.jsonl", '{"objects":["c"],"s":[["on","c"]],"a":["puton","c"],"s2":[]}\n')
        code, _, err = primo("rules", "predict", "--rules", rules, "--experiences", other)
        self.assertEqual(code, 78)
        self.assertIn("on has 1 argument, but 2 in the rules", err)

    def test_exported_ppddl_has_the_successors_that_the_rules_predict(self):
        rules = self.file("R.json", RULES)
        text, err = self.run_primo("export", "--rules", rules, "--format", "ppddl")
        self.assertIn("0.1", err)
        domain = Domain(text)
        rng = random.Random(5)
        situations = [draw_situation(rng) for _ in range(600)]
        data = self.file("s.jsonl", "\n".join(map(json.dumps, situations)))
        out, _ = self.run_primo("predict", "--rules", rules, "--experiences", data)
        changed = 0
        for situation, line in zip(situations, out.splitlines()):
            state = as_state(situation["s"])
            expected = {}
            prediction = json.loads(line)
            for successor, p in prediction["successors"]:
                expected[frozenset(as_state(successor).items())] = p
            same = frozenset(state.items())
            expected[same] = expected.get(same, 0) + prediction["noise"]
            expected = {s: p for s, p in expected.items() if p > 1e-12}
            found = domain.successors(situation["a"], state, situation["objects"])
            self.assertEqual(set(found), set(expected), situation)
            for s, p in expected.items():
                self.assertAlmostEqual(found[s], p, places=9)
            changed += len(expected) > 1
        self.assertGreater(changed, 60)
        dead, err = self.run_primo("export", "--rules", rules, "--format", "ppddl", "--noise", "dead-end")
        self.assertIn("dead end", err)
        for situation, line in zip(situations, out.splitlines()):
            found = Domain(dead).successors(situation["a"], as_state(situation["s"]), situation["objects"])
            lost = sum(p for s, p in found.items() if (("dead-end",), True) in s)
            self.assertAlmostEqual(lost, json.loads(line)["noise"], places=9)

    def test_show_export_diff_and_diagnose_read_what_learn_wrote(self):
        data = self.file("data.jsonl", "\n".join(grasps(100, 1)))
        rules, later = self.folder / "R.json", self.folder / "later.json"
        text, _ = self.run_primo("learn", "--experiences", data, "--out", rules)
        self.assertEqual(self.run_primo("show", "--rules", rules)[0], text)
        self.assertEqual(self.run_primo("export", "--rules", rules, "--format", "json")[0], rules.read_text())
        self.assertIn("\\begin{cases}", self.run_primo("export", "--rules", rules, "--format", "latex")[0])
        self.run_primo("learn", "--experiences", data, self.file("more", "\n".join(grasps(100, 9))), "--out", later)
        self.assertTrue(self.run_primo("diff", "--rules", rules, "--to", later)[0].startswith("~ grasp(X)"))
        self.assertEqual(self.run_primo("diff", "--rules", rules, "--to", rules)[0], "")
        diagnosis = json.loads(self.run_primo("diagnose", "--rules", rules, "--experiences", data)[0])
        self.assertEqual(diagnosis["rules"][0]["covered"], sum(json.loads(rules.read_text())["rules"][0]["counts"]))

    def test_plan_reports_its_probability_of_success(self):
        rules = self.file("R.json", {"rules": [
            {"action": ["grasp", "X"], "context": [["on", "X", "Y"]], "outcomes": [[0.5, [["inhand", "X"], ["not", "on", "X", "Y"]]], [0.5, []]], "noise": 0}],
            "default": {}})
        state = self.file("s.json", {"objects": ["c", "t"], "s": [["on", "c", "t"]]})
        for method in ("uct", "replan"):
            out, _ = self.run_primo("plan", "--rules", rules, "--state", state, "--goal", "inhand(c) and not on(c,t)",
                                    "--horizon", 3, "--method", method, "--json")
            plan = json.loads(out)
            self.assertEqual(plan["steps"], [{"action": ["grasp", "c"], "p": 0.5}])
            self.assertAlmostEqual(plan["success"], 1 - 0.5 ** 3)
        code, _, err = primo("rules", "plan", "--rules", rules, "--state", state, "--goal", "inhand(t)")
        self.assertEqual(code, 1)
        self.assertIn("no way to the goal", err)
        code, _, err = primo("rules", "plan", "--rules", rules, "--state", state, "--goal", "inhand(")
        self.assertEqual(code, 64)
        self.assertIn("--goal: character", err)


if __name__ == "__main__":
    unittest.main(verbosity=2)
