#include <cstdint>
#include <map>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/hash.h"
#include "study/codec.h"

namespace primo::study {
namespace {

/// Hashes a value through the same list of fields that reads and writes it, so that no field can be forgotten. Two
/// hashers with different beginnings make 128 bits: requests number in the millions, and a collision would be answered
/// with another request's reply.
class Digest {
 public:
  explicit Digest(const char* kind) {
    first_.add("primo").add(kind);
    second_.add(kind).add("omirp").add(std::uint64_t{0x9e3779b97f4a7c15ULL});
  }
  std::string text() const { return hex(first_.value()) + hex(second_.value()); }

  template <class T>
  void operator()(const char* name, T& value, const config::Field& = {}) {
    if constexpr (config::detail::IsOptional<T>::value) {
      if (value) (*this)(name, *value);
    } else {
      add(name);
      add(value);
    }
  }

  template <class T>
  void add(const T& value) {
    if constexpr (std::is_arithmetic_v<T> || std::is_enum_v<T>) {
      if constexpr (std::is_same_v<T, double>) {
        both(value);
      } else {
        both(static_cast<std::int64_t>(value));
      }
    } else if constexpr (std::is_convertible_v<T, std::string_view>) {
      both(std::string_view(value));
    } else if constexpr (config::EigenVector<T>) {
      for (int i = 0; i < value.size(); ++i) both(value(i));
    } else if constexpr (requires(T & mutable_value, Digest & digest) { mutable_value.visit(digest); }) {
      const_cast<T&>(value).visit(*this);  // visit is for reading and writing alike; operator() only reads
    } else {
      add_container(value);
    }
  }

  void add(const symbols::Literal& literal) {
    add(literal.predicate);
    add(literal.arguments);
    add(literal.negated);
    if (literal.relation == symbols::Relation::none) return;
    add(static_cast<int>(literal.relation));
    add(static_cast<int>(literal.value));
  }
  void add(const Pose& X) {
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 4; ++column) both(X.matrix()(row, column));
    }
  }
  void add(const scene::ObjectEstimate& object) {
    add(object.name);
    add(object.type);
    add(object.X_WO);
    add(object.shape.type);
    add(object.shape.size);
    add(object.residual);
    add(object.points);
  }
  void add(const scene::SceneEstimate& estimate) {
    add(estimate.scene);
    add(estimate.table);
    add(estimate.objects);
    add(estimate.resolution);
  }

 private:
  template <class T>
  void both(T value) {
    first_.add(value);
    second_.add(value);
  }
  template <class K, class T>
  void add_container(const std::map<K, T>& values) {
    both(static_cast<std::uint64_t>(values.size()));
    for (const auto& [key, value] : values) {
      add(key);
      add(value);
    }
  }
  template <class C>
  void add_container(const C& values) {
    both(static_cast<std::uint64_t>(values.size()));
    for (const auto& value : values) add(value);
  }

  Hasher first_, second_;
};

}  // namespace

std::string key_of(const Rollout& rollout) {
  Digest digest("rollout");
  digest.add(rollout.scenario);
  digest.add(rollout.estimate);
  digest.add(rollout.primitive);
  digest.add(rollout.judge_seed);
  digest.add(rollout.mode);
  digest.add(rollout.judge);
  return digest.text();
}

std::string key_of(const scene::Scenario& scenario) {
  Digest digest("observe");
  digest.add(scenario);
  return digest.text();
}

std::string key_of(const OptimizeGoal& goal) {
  Digest digest("optimize");
  digest.add(goal.study);
  digest.add(goal.part);
  digest.add(goal.round);
  digest.add(goal.primitive);
  digest.add(goal.scenarios);
  digest.add(goal.estimates);
  digest.add(goal.drawn);
  digest.add(goal.held_out);
  digest.add(goal.desired);
  digest.add(goal.optimizer);
  digest.add(goal.algorithms);
  digest.add(goal.restarts);
  digest.add(goal.judge);
  digest.add(goal.seed);
  digest.add(goal.settings);
  return digest.text();
}

std::string key_of(const std::vector<symbols::Experience>& experiences) {
  Digest digest("learn");
  for (const auto& experience : experiences) {
    digest.add(experience.id);
    digest.add(experience.objects);
    digest.add(experience.before);
    digest.add(experience.action);
    digest.add(experience.after);
  }
  return digest.text();
}

}  // namespace primo::study
