// rule_learner: collects experiences by batch and learns the rules of each batch that has grown. The rules say which
// experiences they cover (a digest of the ids), so whoever sent them knows when its batch is complete.
#include <primo_rules.h>

#include <condition_variable>
#include <list>
#include <map>
#include <mutex>

#include "bus/latched.h"
#include "rules/learner.h"
#include "service/service.h"
#include "wire/wire.h"

namespace primo {
namespace {

using std::chrono::milliseconds;

struct RuleLearnerConfig {
  rules::LearnerSettings learner;
  int quiet_ms = 20;
  int batches = 8;
  template <class V>
  void visit(V&& v) {
    v("learner", learner, {});
    v("quiet_ms", quiet_ms,
      {.help = "learn when no experience has come for so long", .unit = "ms", .min = 1, .max = 10000});
    v("batches", batches, {.help = "kept at most; the one that was quiet longest goes first", .min = 1, .max = 10000});
  }
};

struct Batch {
  std::map<std::string, symbols::Experience> experiences;  // by id
  std::string digest;                                      // of what `rules` were learned from; empty: nothing yet
  topics::msg::RuleSet rules;
};

/// Experiences on their way from the bus to the learning thread.
class Inbox {
 public:
  void put(topics::msg::Experience&& experience) {
    {
      const std::lock_guard lock(mutex_);
      waiting_.push_back(std::move(experience));
    }
    changed_.notify_one();
  }
  /// What came within `timeout`; empty: nothing.
  std::list<topics::msg::Experience> take(milliseconds timeout) {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, timeout, [this] { return !waiting_.empty(); });
    return std::exchange(waiting_, {});
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::list<topics::msg::Experience> waiting_;
};

/// "*" unless all experiences are of one action.
std::string action_of(const Batch& batch) {
  const std::string& first = batch.experiences.begin()->second.action.predicate;
  for (const auto& [id, experience] : batch.experiences) {
    if (experience.action.predicate != first) return "*";
  }
  return first;
}

void learn(const std::string& name, Batch& batch, const RuleLearnerConfig& config, service::Context& context) {
  std::vector<std::string> ids;
  std::vector<symbols::Experience> experiences;
  for (const auto& [id, experience] : batch.experiences) {
    ids.push_back(id);
    experiences.push_back(experience);
  }
  const std::string digest = wire::experience_digest(ids);
  // The same batch may be sent again, by a sender that has started again: the answer stands.
  if (digest == batch.digest) return;
  context.status().job_started();
  const auto rules = rules::learn(experiences, config.learner);
  batch.rules = wire::to_wire(rules.ok() ? *rules : rules::RuleSet{}, name, action_of(batch),
                              static_cast<int>(ids.size()), digest);
  if (!rules.ok()) batch.rules.error(rules.error().message);
  batch.digest = digest;
  context.status().job_finished(rules.ok(), rules.ok() ? "" : rules.error().message);
  context.log().info("batch {}: {} experiences, {} rules", name, ids.size(), batch.rules.rules().size());
}

Status run(const RuleLearnerConfig& config, service::Context& context) {
  PRIMO_ASSIGN(auto publisher, bus::Publisher<topics::msg::RuleSet>::create(context.participant(), topics::kRuleSet));
  Inbox inbox;
  PRIMO_ASSIGN(const auto subscription,
               bus::Subscription<topics::msg::Experience>::create(
                   context.participant(), topics::kExperience,
                   [&](topics::msg::Experience&& experience) { inbox.put(std::move(experience)); }));
  context.status().set_state(bus::State::idle);
  std::map<std::string, Batch> batches;
  std::list<std::string> touched, order;  // since the last learning; all, the longest quiet first
  while (!context.stopping()) {
    const auto arrived = inbox.take(touched.empty() ? milliseconds(100) : milliseconds(config.quiet_ms));
    for (const auto& message : arrived) {
      auto experience = wire::from_wire(message);
      if (!experience.ok()) {
        context.status().set_error("an experience of batch '" + message.batch() + "': " + experience.error().message);
        context.log().warn("an experience of batch '{}' was refused: {}", message.batch(), experience.error().message);
        continue;
      }
      touched.remove(message.batch());
      touched.push_back(message.batch());
      order.remove(message.batch());
      order.push_back(message.batch());
      const std::string id = experience->id;
      batches[message.batch()].experiences.try_emplace(id, std::move(experience).value());
    }
    if (!arrived.empty()) continue;
    for (const auto& name : touched) {
      learn(name, batches[name], config, context);
      PRIMO_TRY(publisher.publish(batches[name].rules));
    }
    touched.clear();
    for (; order.size() > static_cast<std::size_t>(config.batches); order.pop_front()) batches.erase(order.front());
  }
  return success();
}

}  // namespace
}  // namespace primo

int main(int argc, char** argv) {
  return primo::service::run<primo::RuleLearnerConfig>("rule_learner", argc, argv, primo::run);
}
