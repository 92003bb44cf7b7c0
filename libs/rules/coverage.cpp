#include "rules/coverage.h"

#include <algorithm>
#include <bit>

namespace primo::rules {
namespace {

constexpr std::size_t kMaxBytes = std::size_t{192} << 20;
constexpr int kWordBits = 64;

std::uint64_t low_bits(int n) { return n >= kWordBits ? ~std::uint64_t{0} : (std::uint64_t{1} << n) - 1; }

/// The deictic variables that the literal mentions, ascending.
std::vector<int> deictic(const LiftedLiteral& literal, int arguments) {
  std::vector<int> found;
  for (const auto term : terms(literal.atom)) {
    if (term >= arguments) found.push_back(term);
  }
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  return found;
}

/// The literal with its deictic variables renamed to the first ones.
LiftedLiteral with_first_variables(LiftedLiteral literal, const std::vector<int>& variables, int arguments) {
  for (auto& term : terms(literal.atom)) {
    const auto at = std::find(variables.begin(), variables.end(), term);
    if (at != variables.end()) term = static_cast<std::int16_t>(arguments + (at - variables.begin()));
  }
  return literal;
}

}  // namespace

struct Coverage::Plan {
  struct Pair {
    std::size_t first;  // deictic variable, counted from 0; the second is the one the pair is listed for
    const std::uint64_t* sets;
  };
  struct Variable {
    std::vector<const std::uint64_t*> sets;
    std::vector<Pair> pairs;
    std::vector<LiftedLiteral> others;  // of three deictic variables or more, the last of which this is
  };
  const Form* form = nullptr;
  Bits possible;
  std::vector<Variable> variables;
};

Coverage::Form& Coverage::form(const std::vector<std::int16_t>& action) {
  Form& form = forms_[action];
  if (form.seen == scenes_.size()) return form;
  form.action = action;
  form.arguments = static_cast<std::size_t>(count_arguments(action));
  form.match.resize(scenes_.size());
  std::vector<std::int16_t> binding;
  for (; form.seen < scenes_.size(); ++form.seen) {
    const Scene& scene = scenes_[form.seen];
    const bool matches = bind_action(action, scene, binding);
    if (matches) form.match.set(form.seen);
    binding.resize(form.arguments, -1);
    std::uint64_t free = matches ? low_bits(scene.objects) : 0;
    for (const auto object : binding) {
      form.bound.push_back(object);
      if (matches && object < kWordBits) free &= ~(std::uint64_t{1} << object);
    }
    form.free.push_back(free);
  }
  return form;
}

void Coverage::extend_offsets() {
  for (std::size_t i = offsets_.size() - 1; i < scenes_.size(); ++i) {
    offsets_.push_back(offsets_.back() + static_cast<std::size_t>(scenes_[i].objects));
    wide_ = wide_ || scenes_[i].objects > kWordBits;
  }
}

std::vector<std::int16_t> Coverage::arguments(const Form& form, std::size_t scene) const {
  const auto* from = form.bound.data() + scene * form.arguments;
  return {from, from + form.arguments};
}

const Bits& Coverage::facts(Form& form, const LiftedLiteral& literal) {
  auto& known = form.facts[literal];
  if (known.seen == scenes_.size()) return known.bits;
  known.bits.resize(scenes_.size());
  for (; known.seen < scenes_.size(); ++known.seen) {
    if (form.match.test(known.seen) && holds(scenes_[known.seen], literal, arguments(form, known.seen))) {
      known.bits.set(known.seen);
    }
  }
  return known.bits;
}

const std::vector<std::uint64_t>& Coverage::unary(Form& form, const LiftedLiteral& literal) {
  auto& known = form.unary[literal];
  if (known.size() == scenes_.size()) return known;
  bytes_ += (scenes_.size() - known.size()) * sizeof(std::uint64_t);
  known.reserve(scenes_.size());
  for (std::size_t i = known.size(); i < scenes_.size(); ++i) {
    std::uint64_t set = 0;
    if (form.match.test(i)) {
      auto binding = arguments(form, i);
      binding.push_back(0);
      for (std::int16_t object = 0; object < scenes_[i].objects; ++object) {
        binding.back() = object;
        if (holds(scenes_[i], literal, binding)) set |= std::uint64_t{1} << object;
      }
    }
    known.push_back(set);
  }
  return known;
}

const std::vector<std::uint64_t>& Coverage::pairs(Form& form, const LiftedLiteral& literal) {
  auto& known = form.pairs[literal];
  if (known.size() == offsets_.back()) return known;
  const auto begin = std::lower_bound(offsets_.begin(), offsets_.end(), known.size()) - offsets_.begin();
  bytes_ += (offsets_.back() - known.size()) * sizeof(std::uint64_t);
  known.resize(offsets_.back(), 0);
  for (auto i = static_cast<std::size_t>(begin); i < scenes_.size(); ++i) {
    if (!form.match.test(i)) continue;
    auto binding = arguments(form, i);
    binding.resize(binding.size() + 2);
    for (std::int16_t a = 0; a < scenes_[i].objects; ++a) {
      binding[form.arguments] = a;
      for (std::int16_t b = 0; b < scenes_[i].objects; ++b) {
        binding[form.arguments + 1] = b;
        if (holds(scenes_[i], literal, binding)) {
          known[offsets_[i] + static_cast<std::size_t>(a)] |= std::uint64_t{1} << b;
        }
      }
    }
  }
  return known;
}

Coverage::Plan Coverage::plan(Form& form, const RuleKey& key) {
  const int arguments = static_cast<int>(form.arguments);
  Plan plan{.form = &form, .possible = form.match, .variables = {}};
  plan.variables.resize(static_cast<std::size_t>(key.variables - arguments));
  for (const auto& literal : key.context) {
    const auto variables = deictic(literal, arguments);
    if (variables.empty()) {
      plan.possible &= facts(form, literal);
      continue;
    }
    auto& last = plan.variables[static_cast<std::size_t>(variables.back() - arguments)];
    const auto renamed = with_first_variables(literal, variables, arguments);
    if (variables.size() == 1) {
      last.sets.push_back(unary(form, renamed).data());
    } else if (variables.size() == 2) {
      last.pairs.push_back({static_cast<std::size_t>(variables.front() - arguments), pairs(form, renamed).data()});
    } else {
      last.others.push_back(literal);
    }
  }
  return plan;
}

int Coverage::bind(const Plan& plan, std::size_t scene, std::size_t variable, std::uint64_t free,
                   std::vector<std::int16_t>& trial, std::int16_t* binding) const {
  const auto& wanted = plan.variables[variable];
  std::uint64_t set = free;
  for (const auto* sets : wanted.sets) set &= sets[scene];
  for (const auto& pair : wanted.pairs) {
    const auto first = static_cast<std::size_t>(trial[plan.form->arguments + pair.first]);
    set &= pair.sets[offsets_[scene] + first];
  }
  int found = 0;
  for (; set != 0 && found < 2; set &= set - 1) {
    const int object = std::countr_zero(set);
    trial[plan.form->arguments + variable] = static_cast<std::int16_t>(object);
    const bool holds_all =
        wanted.others.empty() || std::all_of(wanted.others.begin(), wanted.others.end(),
                                             [&](const LiftedLiteral& l) { return holds(scenes_[scene], l, trial); });
    if (!holds_all) continue;
    if (variable + 1 < plan.variables.size()) {
      const std::uint64_t rest = free & ~(std::uint64_t{1} << object);
      found += bind(plan, scene, variable + 1, rest, trial, binding);
    } else if (++found == 1) {
      std::copy(trial.begin(), trial.end(), binding);
    }
  }
  return std::min(found, 2);
}

Covered Coverage::cover(const RuleKey& key, std::size_t begin) {
  extend_offsets();
  if (wide_) return cover_wide(key, begin);
  const Plan plan = this->plan(form(key.action), key);
  const Form& form = *plan.form;
  Covered covered{.examples = {}, .bindings = {}, .variables = key.variables};
  std::vector<std::int16_t> trial(static_cast<std::size_t>(key.variables)), binding(trial);
  for (std::size_t w = begin / 64; w < plan.possible.words().size(); ++w) {
    std::uint64_t word = plan.possible.words()[w];
    if (w == begin / 64) word &= ~low_bits(static_cast<int>(begin % 64));
    for (; word != 0; word &= word - 1) {
      const std::size_t scene = w * 64 + static_cast<std::size_t>(std::countr_zero(word));
      const auto* bound = form.bound.data() + scene * form.arguments;
      std::copy(bound, bound + form.arguments, trial.begin());
      if (plan.variables.empty()) {
        binding = trial;
      } else if (bind(plan, scene, 0, form.free[scene], trial, binding.data()) != 1) {
        continue;
      }
      covered.examples.push_back(static_cast<std::uint32_t>(scene));
      covered.bindings.insert(covered.bindings.end(), binding.begin(), binding.end());
    }
  }
  return covered;
}

Covered Coverage::cover_wide(const RuleKey& key, std::size_t begin) const {
  const Pattern pattern(key.action, key.variables, key.context);
  Covered covered{.examples = {}, .bindings = {}, .variables = key.variables};
  std::vector<std::int16_t> binding;
  for (std::size_t i = begin; i < scenes_.size(); ++i) {
    if (pattern.count_bindings(scenes_[i], binding) != 1) continue;
    covered.examples.push_back(static_cast<std::uint32_t>(i));
    covered.bindings.insert(covered.bindings.end(), binding.begin(), binding.end());
  }
  return covered;
}

void Coverage::limit_memory() {
  if (bytes_ <= kMaxBytes) return;
  forms_.clear();
  bytes_ = 0;
}

}  // namespace primo::rules
