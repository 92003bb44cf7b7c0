// The state of a study: answers to jobs, each on disk before it is used, and the course of the optimization. SQLite in
// WAL mode with synchronous=FULL. Two processes (conductor, optimizer) may write the same file.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/result.h"
#include "study/backend.h"

struct sqlite3;

namespace primo::study {

/// The reply to one job. The key is the content of the request, so the same question is never asked twice.
struct Answer {
  std::string key;
  std::string kind;    ///< rollout, observe, learn, optimize
  std::string reply;   ///< JSON
  double seconds = 0;  ///< how long it took; for the report only
};

/// One evaluation of γ: a point of the learning curve.
struct EvaluationRecord {
  std::string part;  ///< of the study
  int round = 0;
  std::string algorithm;
  int restart = 0;
  int generation = 0;
  int index = 0;
  double gamma = 0;
  int successes = 0;      ///< of the K training scenarios
  int final_pose = 0;     ///< scenarios whose final pose alone passes
  int scenarios = 0;      ///< K; fewer where it was given up or dropped
  std::vector<double> x;  ///< log10 ρ
};

/// A recommendation re-evaluated with fresh seeds.
struct FinalistRecord {
  std::string part;  ///< of the study
  int round = 0;
  std::string algorithm;  ///< cma, monte_carlo, …; "P" for the primitive the optimization began with
  int restart = 0;
  std::string kind;  ///< mean, best, start
  double gamma = 0;
  Rate success;
  bool chosen = false;
  std::vector<double> x;  ///< log10 ρ
};

/// γ around the chosen primitive along one of its open entries: at the choice, a step below it, a step above it.
struct SensitivityRecord {
  std::string part;  ///< of the study
  int round = 0;
  int index = 0;              ///< of the entry
  std::string entry;          ///< its name
  bool log = false;           ///< whether x is log10 of it
  std::array<double, 3> x{};  ///< coordinate at the choice, below, above; the choice's own where a bound leaves no step
  std::array<double, 3> gamma{};
  std::array<Rate, 3> success{};
};

/// Wall-clock time of a stage that ran to its end. Never part of a result.
struct TimingRecord {
  std::string part;  ///< of the study
  int round = 0;
  std::string stage;
  double seconds = 0;
  std::int64_t rollouts = 0;  ///< answered by workers, not by the journal
};

class Journal {
 public:
  /// Opens the journal of this file, creating it when it does not exist. A file that is damaged, of another format, or
  /// not a journal is an Error (data) and is left as it is; a directory that cannot be written or a lock that is not
  /// released is Code::unavailable.
  static Result<Journal> open(const std::filesystem::path& file);
  /// The same, but the file must exist.
  static Result<Journal> open_existing(const std::filesystem::path& file);

  Journal(Journal&&) noexcept;
  Journal& operator=(Journal&&) noexcept;
  ~Journal();

  /// The reply recorded under this key. Error (data): the record is damaged.
  Result<std::optional<std::string>> find(const std::string& key);

  /// Appends these answers in one transaction; they are on disk when it returns. Where a key is there already, its
  /// first reply stays: the replies that count are returned, in order.
  Result<std::vector<std::string>> record(std::span<const Answer> answers);

  Status record_evaluations(std::span<const EvaluationRecord> evaluations);
  Result<std::vector<EvaluationRecord>>
  evaluations();  ///< in order of part, round, algorithm, restart, generation, index
  Status record_finalists(std::span<const FinalistRecord> finalists);
  Result<std::vector<FinalistRecord>> finalists();
  Status record_sensitivities(std::span<const SensitivityRecord> sensitivities);
  Result<std::vector<SensitivityRecord>> sensitivities();  ///< in order of part, round, entry
  Status record_timing(const TimingRecord& timing);
  Result<std::vector<TimingRecord>> timings();          ///< in order of arrival
  Result<std::int64_t> count(const std::string& kind);  ///< answers of this kind

  const std::filesystem::path& file() const { return file_; }

  static constexpr int kVersion = 3;

 private:
  struct Closer {
    void operator()(sqlite3* database) const;
  };
  Journal(std::filesystem::path file, sqlite3* database);
  static Result<Journal> open_file(const std::filesystem::path& file);
  std::filesystem::path file_;
  std::unique_ptr<sqlite3, Closer> database_;
};

/// The journal's file in a study's directory.
std::filesystem::path journal_file(const std::filesystem::path& study_directory);

/// An Evaluator that asks another one only what the journal does not know. Answers that arrived together are appended
/// in one transaction, and passed on after it.
class JournaledEvaluator : public Evaluator {
 public:
  JournaledEvaluator(Evaluator& inner, Journal& journal) : inner_(inner), journal_(journal) {}
  Status evaluate(std::span<const Rollout> rollouts,
                  const std::function<void(std::size_t index, RolloutResult result)>& on_result) override;
  std::int64_t asked() const { return asked_; }        ///< rollouts that the inner evaluator did
  std::int64_t recalled() const { return recalled_; }  ///< rollouts that the journal answered

 private:
  Evaluator& inner_;
  Journal& journal_;
  std::int64_t asked_ = 0, recalled_ = 0;
};

}  // namespace primo::study
