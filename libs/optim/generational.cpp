#include "optim/generational.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace primo::optim {
namespace {
constexpr int kMostCandidates = 1 << 20;  // a generation; restored states are held to it
}  // namespace

void Generational::begin() {
  best_fitness_ = -std::numeric_limits<double>::infinity();
  fitness_.assign(static_cast<std::size_t>(wanted()), std::nullopt);
  first_ = samples().front();
}

std::vector<Candidate> Generational::ask() const {
  std::vector<Candidate> candidates;
  if (done()) return candidates;
  for (auto& x : samples()) candidates.push_back({number_, static_cast<int>(candidates.size()), std::move(x)});
  return candidates;
}

std::string Generational::stop_reason() const {
  if (auto reason = stopped(); !reason.empty()) return reason;
  if (size() > 0 && size() <= remaining()) return {};
  std::string text = "the budget of " + std::to_string(settings_.evaluations) + " evaluations is spent";
  if (remaining() > 0) {
    text += " (" + std::to_string(remaining()) + " left, a generation is " + std::to_string(size()) + ")";
  }
  return text;
}

Status Generational::tell(int generation, int index, double fitness) {
  const std::string which = "candidate " + std::to_string(index) + " of generation " + std::to_string(generation);
  if (generation < 0 || generation > number_ || (generation == number_ && done())) {
    return Error{Code::data, which + " has not been asked; the present generation is " + std::to_string(number_) +
                                 (done() ? ", and the search is over" : "")};
  }
  if (index < 0 || (generation == number_ && index >= size())) {
    return Error{Code::data, which + " does not exist; the indices are 0 to " + std::to_string(size() - 1)};
  }
  if (!std::isfinite(fitness)) {
    return Error{Code::data, "the fitness of " + which + " is " + std::to_string(fitness) + "; it must be finite"};
  }
  if (generation < number_) return success();
  auto& slot = fitness_[static_cast<std::size_t>(index)];
  if (slot.has_value()) return success();
  slot = fitness;
  if (++told_ < size()) return success();

  std::vector<double> all;
  for (const auto& value : fitness_) all.push_back(*value);
  const auto top = std::max_element(all.begin(), all.end());  // the first one among equals
  if (*top > best_fitness_) {
    best_ = samples()[static_cast<std::size_t>(top - all.begin())];
    best_fitness_ = *top;
  }
  advance(all);
  before_ += told_;
  told_ = 0;
  ++number_;
  fitness_.assign(static_cast<std::size_t>(wanted()), std::nullopt);
  return success();
}

State Generational::state() const {
  State state;
  state["generation"] = {static_cast<double>(number_)};
  state["evaluations"] = {static_cast<double>(before_)};
  state["size"] = {static_cast<double>(size())};
  auto &indices = state["told_indices"], &values = state["told_fitness"];
  for (int k = 0; k < size(); ++k) {
    const auto& value = fitness_[static_cast<std::size_t>(k)];
    if (!value.has_value()) continue;
    indices.push_back(k);
    values.push_back(*value);
  }
  state["best"] = best_;
  state["best_fitness"] = best_.empty() ? std::vector<double>{} : std::vector<double>{best_fitness_};
  save(state);
  return state;
}

Status Generational::restore(const State& state) {
  const StateReader reader(state);
  constexpr int kMost = std::numeric_limits<int>::max() - kMostCandidates;
  PRIMO_ASSIGN(number_, reader.whole("generation", 0, kMost));
  PRIMO_ASSIGN(before_, reader.whole("evaluations", 0, kMost));
  PRIMO_ASSIGN(const int size, reader.whole("size", 0, kMostCandidates));
  PRIMO_ASSIGN(const auto indices, reader.numbers("told_indices"));
  PRIMO_ASSIGN(const auto values, reader.numbers("told_fitness", indices.size()));
  PRIMO_ASSIGN(best_, reader.numbers("best"));
  PRIMO_ASSIGN(const auto best_fitness, reader.numbers("best_fitness", best_.empty() ? 0 : 1));
  bool inside = best_.empty() || best_.size() == bounds_.lower.size();
  for (std::size_t i = 0; inside && i < best_.size(); ++i) {
    inside = best_[i] >= bounds_.lower[i] && best_[i] <= bounds_.upper[i];
  }
  if (!inside) return Error{Code::data, "the optimizer's state: 'best' is no point of the box"};
  if (!best_.empty()) best_fitness_ = best_fitness[0];
  told_ = 0;
  PRIMO_TRY(load(reader));

  // Before anything of it is told, a generation may get another size from another budget.
  fitness_.assign(static_cast<std::size_t>(indices.empty() ? wanted() : size), std::nullopt);
  for (std::size_t i = 0; i < indices.size(); ++i) {
    const double index = indices[i];
    if (!(index >= 0 && index < static_cast<double>(fitness_.size()) && index == std::floor(index))) {
      return Error{Code::data, "the optimizer's state: 'told_indices' names no candidate"};
    }
    auto& slot = fitness_[static_cast<std::size_t>(index)];
    if (slot.has_value()) return Error{Code::data, "the optimizer's state: 'told_indices' names a candidate twice"};
    slot = values[i];
    ++told_;
  }
  if (told_ > 0 && told_ == this->size()) {
    return Error{Code::data, "the optimizer's state: its generation is complete, but was not learned from"};
  }
  return success();
}

std::vector<double> Generational::in_box(const std::vector<double>& u) const {
  std::vector<double> x(u.size());
  for (std::size_t i = 0; i < u.size(); ++i) {
    const double lower = bounds_.lower[i], upper = bounds_.upper[i];
    x[i] = std::clamp(lower + std::clamp(u[i], 0.0, 1.0) * (upper - lower), lower, upper);
  }
  return x;
}

}  // namespace primo::optim
