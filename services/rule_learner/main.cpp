// rule_learner: collects experiences by batch and learns the rules of each batch that has grown, from what it computed
// before. The rules say which experiences they cover (a digest of the ids), so whoever sent them knows when its batch
// is complete; and what is new in them.
#include <primo_rules.h>

#include <condition_variable>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <set>

#include "bus/latched.h"
#include "rules/analysis.h"
#include "rules/online.h"
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
  std::unique_ptr<rules::OnlineLearner> learner;
  std::set<std::string> ids;
  std::string action;   // "*" unless all experiences are of one action
  std::string digest;   // of what `message` was learned from; empty: nothing yet
  std::string refused;  // why an experience could not be used
  std::uint32_t version = 0;
  rules::RuleSet last;
  topics::msg::RuleSet message;
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

/// Takes an experience into its batch. One whose id is there already changes nothing, whatever it holds.
Status take(Batch& batch, const symbols::Experience& experience, const RuleLearnerConfig& config) {
  if (!batch.learner) {
    PRIMO_ASSIGN(batch.learner, rules::OnlineLearner::create(config.learner));
  }
  if (!batch.ids.insert(experience.id).second) return success();
  const std::string& action = experience.action.predicate;
  batch.action = batch.action.empty() || batch.action == action ? action : "*";
  const auto noted = batch.learner->note(experience, "experience " + experience.id);
  if (!noted.ok()) batch.refused = noted.error().message;
  return success();
}

void learn(const std::string& name, Batch& batch, service::Context& context) {
  const std::string digest = wire::experience_digest({batch.ids.begin(), batch.ids.end()});
  // The same batch may be sent again, by a sender that has started again: the answer stands.
  if (digest == batch.digest) return;
  context.status().job_started();
  const bool ok = batch.refused.empty();
  if (ok) batch.learner->settle();
  const rules::RuleSet rules = ok ? batch.learner->rules() : rules::RuleSet{};
  const int experiences = static_cast<int>(batch.ids.size());
  batch.message = wire::to_wire(rules, name, batch.action, experiences, digest);
  wire::add_news({++batch.version, ok ? batch.learner->score() : 0, rules::difference(batch.last, rules)},
                 batch.message);
  batch.message.error(batch.refused);
  batch.last = rules;
  batch.digest = digest;
  context.status().job_finished(ok, batch.refused);
  context.log().info("batch {}: {} experiences, {} rules, version {}, score {:.2f}", name, experiences,
                     rules.rules.size(), batch.version, batch.message.score());
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
      PRIMO_TRY(take(batches[message.batch()], *experience, config));
    }
    if (!arrived.empty()) continue;
    for (const auto& name : touched) {
      learn(name, batches[name], context);
      PRIMO_TRY(publisher.publish(batches[name].message));
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
