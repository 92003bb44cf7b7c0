#include "study/journal.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sqlite3.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>
#include <thread>

#include "core/files.h"
#include "core/random.h"
#include "study/codec.h"
#include "synthetic.h"

namespace primo::study {
namespace {

namespace fs = std::filesystem;

class JournalTest : public ::testing::Test {
 protected:
  void SetUp() override {
    directory = fs::temp_directory_path() / ("primo_journal_" + std::to_string(::getpid()) + "_" +
                                             ::testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::remove_all(directory);
    fs::create_directories(directory);
    file = directory / "journal.db";
  }
  void TearDown() override { fs::remove_all(directory); }

  /// A closed journal with this many answers, checkpointed into the one file.
  void fill(int answers) {
    auto journal = Journal::open(file);
    ASSERT_TRUE(journal.ok()) << journal.error().message;
    std::vector<Answer> batch;
    for (int i = 0; i < answers; ++i)
      batch.push_back({"key" + std::to_string(i), "rollout", encode(test::perfect_grasp()), 0.1});
    ASSERT_TRUE(journal->record(batch).ok());
  }
  std::string bytes() const { return read_file(file).value(); }
  void put(const std::string& content) const { std::ofstream(file, std::ios::binary | std::ios::trunc) << content; }
  void expect_refused(const std::string& word) {
    const auto before = bytes();
    const auto journal = Journal::open(file);
    ASSERT_FALSE(journal.ok());
    EXPECT_EQ(journal.error().code, Code::data);
    EXPECT_EQ(exit_code(journal.error().code), 78);
    EXPECT_NE(journal.error().message.find(file.string()), std::string::npos) << journal.error().message;
    EXPECT_NE(journal.error().message.find(word), std::string::npos) << journal.error().message;
    EXPECT_EQ(bytes(), before) << "a journal that is refused is left as it is";
  }
  fs::path directory, file;
};

TEST_F(JournalTest, remembers_answers_across_opening) {
  fill(100);
  auto journal = Journal::open(file);
  ASSERT_TRUE(journal.ok());
  EXPECT_EQ(journal->count("rollout").value(), 100);
  const auto found = journal->find("key42");
  ASSERT_TRUE(found.ok());
  EXPECT_EQ(found->value(), encode(test::perfect_grasp()));
  EXPECT_FALSE(journal->find("key100")->has_value());
}

TEST_F(JournalTest, keeps_the_first_of_two_answers_to_one_question) {
  auto journal = Journal::open(file);
  ASSERT_TRUE(journal.ok());
  const Answer first{"k", "rollout", "1", 0}, second{"k", "rollout", "2", 0};
  EXPECT_EQ(journal->record({&first, 1})->front(), "1");
  EXPECT_EQ(journal->record({&second, 1})->front(), "1");
}

TEST_F(JournalTest, keeps_the_course_of_an_optimization_once_however_often_it_is_told) {
  auto journal = Journal::open(file);
  ASSERT_TRUE(journal.ok());
  const EvaluationRecord record{"grasp", 0, "cma", 1, 2, 3, 0.1 + 0.2, 4, 5, 6, {1.0 / 3, -3, 9}};
  for (int i = 0; i < 2; ++i) ASSERT_TRUE(journal->record_evaluations({&record, 1}).ok());
  const auto back = journal->evaluations();
  ASSERT_TRUE(back.ok());
  ASSERT_EQ(back->size(), 1u);
  EXPECT_EQ(back->front().gamma, record.gamma);
  EXPECT_EQ(back->front().x, record.x);
  EXPECT_EQ(back->front().index, 3);
}

TEST_F(JournalTest, refuses_what_is_no_journal) {
  put("");
  expect_refused("not a journal");
  put("this is not a database at all, but it is a text of more than one hundred characters, so that a header would fit "
      "in");
  expect_refused("not a journal");
  fs::remove(file);
  sqlite3* other = nullptr;
  ASSERT_EQ(sqlite3_open(file.c_str(), &other), SQLITE_OK);
  sqlite3_exec(other, "CREATE TABLE t (x)", nullptr, nullptr, nullptr);
  sqlite3_close(other);
  expect_refused("not a study's journal");
}

TEST_F(JournalTest, refuses_another_format_version) {
  fill(1);
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open(file.c_str(), &database), SQLITE_OK);
  sqlite3_exec(database, "PRAGMA user_version = 99", nullptr, nullptr, nullptr);
  sqlite3_close(database);
  expect_refused("version 99");
}

TEST_F(JournalTest, refuses_a_truncated_file) {
  fill(300);
  const auto whole = bytes();
  for (const double share : {0.1, 0.5, 0.9}) {
    put(whole.substr(0, static_cast<std::size_t>(share * static_cast<double>(whole.size()))));
    expect_refused("damaged");
  }
}

TEST_F(JournalTest, never_returns_an_answer_whose_bytes_have_changed) {
  fill(200);
  const auto whole = bytes();
  const auto right = encode(test::perfect_grasp());
  Random random(1, "damage");
  int refused = 0;
  for (int trial = 0; trial < 150; ++trial) {
    std::string damaged = whole;
    for (int i = 0; i < 20; ++i)
      damaged[100 + random.below(damaged.size() - 100)] = static_cast<char>(random.below(256));
    put(damaged);
    auto journal = Journal::open(file);
    if (!journal.ok()) {
      EXPECT_EQ(journal.error().code, Code::data) << journal.error().message;
      ++refused;
      continue;
    }
    for (int i = 0; i < 200; ++i) {
      const auto found = journal->find("key" + std::to_string(i));
      if (!found.ok()) {
        EXPECT_EQ(found.error().code, Code::data) << found.error().message;
        ++refused;
        break;
      }
      if (found->has_value()) {
        ASSERT_EQ(found->value(), right);
      }
    }
  }
  EXPECT_GT(refused, 100) << "twenty changed bytes are nearly always noticed";
}

TEST_F(JournalTest, says_when_there_is_none_or_the_directory_cannot_be_used) {
  const auto none = Journal::open_existing(file);
  ASSERT_FALSE(none.ok());
  EXPECT_EQ(none.error().code, Code::config);
  const auto nowhere = Journal::open(directory / "missing" / "journal.db");
  ASSERT_FALSE(nowhere.ok());
  EXPECT_EQ(nowhere.error().code, Code::unavailable);
}

TEST_F(JournalTest, takes_two_writers_at_once) {
  const int each = 200;
  const auto write = [&](int writer) {
    auto journal = Journal::open(file);
    ASSERT_TRUE(journal.ok()) << journal.error().message;
    for (int i = 0; i < each; ++i) {
      const Answer answer{std::to_string(writer) + "/" + std::to_string(i), "rollout", std::to_string(i), 0};
      const auto status = journal->record({&answer, 1});
      ASSERT_TRUE(status.ok()) << status.error().message;
    }
  };
  std::thread other(write, 1);
  write(2);
  other.join();
  auto journal = Journal::open(file);
  ASSERT_TRUE(journal.ok());
  EXPECT_EQ(journal->count("rollout").value(), 2 * each);
}

TEST_F(JournalTest, is_readable_and_whole_after_its_writer_was_killed_anywhere) {
  std::int64_t last = 0;
  for (int round = 0; round < 20; ++round) {
    int pipe_ends[2];
    ASSERT_EQ(::pipe(pipe_ends), 0);
    const pid_t child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      auto journal = Journal::open(file);
      if (!journal.ok()) ::_exit(1);
      for (std::int64_t i = last;; ++i) {
        const Answer batch[] = {{"a" + std::to_string(i), "rollout", std::string(2000, 'x'), 0},
                                {"b" + std::to_string(i), "rollout", std::string(2000, 'y'), 0}};
        if (!journal->record(batch).ok()) ::_exit(2);
        if (::write(pipe_ends[1], &i, sizeof i) != sizeof i) ::_exit(3);
      }
    }
    ::close(pipe_ends[1]);
    std::int64_t told = last - 1;
    for (int heard = 0; heard < 2; ++heard) ASSERT_EQ(::read(pipe_ends[0], &told, sizeof told), ssize_t{sizeof told});
    ::usleep(static_cast<useconds_t>(137 * round));  // somewhere in the next transactions
    ::kill(child, SIGKILL);
    int status = 0;
    ::waitpid(child, &status, 0);
    ASSERT_TRUE(WIFSIGNALED(status)) << "the writer ended by itself: " << WEXITSTATUS(status);
    for (std::int64_t i = 0; ::read(pipe_ends[0], &i, sizeof i) == sizeof i;) told = i;
    ::close(pipe_ends[0]);

    auto journal = Journal::open(file);
    ASSERT_TRUE(journal.ok()) << journal.error().message;
    for (std::int64_t i = 0; i <= told; ++i) {
      ASSERT_TRUE(journal->find("a" + std::to_string(i))->has_value()) << "what was recorded before the kill is there";
      ASSERT_TRUE(journal->find("b" + std::to_string(i))->has_value());
    }
    const auto count = journal->count("rollout").value();
    EXPECT_EQ(count % 2, 0) << "a transaction is there as a whole or not at all";
    last = count / 2;
  }
  EXPECT_GE(last, 40);
}

std::vector<Rollout> rollouts(int n) {
  std::vector<Rollout> list;
  for (int i = 0; i < n; ++i) {
    Rollout rollout;
    rollout.scenario = test::scenario("s");
    rollout.estimate = test::estimate(rollout.scenario);
    rollout.primitive = test::primitive(2).with_log_rho({0.1 * i, 3});
    list.push_back(std::move(rollout));
  }
  return list;
}

TEST_F(JournalTest, an_evaluator_asks_only_what_it_does_not_know) {
  auto journal = Journal::open(file);
  ASSERT_TRUE(journal.ok());
  test::FunctionEvaluator inner([](const Rollout& r) { return test::bowl(r); });
  JournaledEvaluator evaluator(inner, *journal);
  const auto all = rollouts(10);
  const auto run = [&](std::span<const Rollout> some) {
    std::vector<std::string> results(some.size());
    const auto status =
        evaluator.evaluate(some, [&](std::size_t i, const RolloutResult& r) { results[i] = encode(r); });
    EXPECT_TRUE(status.ok());
    return results;
  };
  const auto first = run(std::span(all).subspan(0, 4));
  EXPECT_EQ(inner.calls, 4);
  const auto second = run(all);
  EXPECT_EQ(inner.calls, 10);
  EXPECT_EQ(run(all), second);
  EXPECT_EQ(inner.calls, 10);
  EXPECT_TRUE(std::equal(first.begin(), first.end(), second.begin()));
  EXPECT_EQ(evaluator.recalled(), 14);
}

TEST_F(JournalTest, an_evaluator_asks_once_for_equal_rollouts) {
  auto journal = Journal::open(file);
  ASSERT_TRUE(journal.ok());
  test::FunctionEvaluator inner([](const Rollout& r) { return test::bowl(r); });
  JournaledEvaluator evaluator(inner, *journal);
  auto same = rollouts(1);
  same.push_back(same[0]);
  same.push_back(same[0]);
  int answers = 0;
  ASSERT_TRUE(evaluator.evaluate(same, [&](std::size_t, const RolloutResult&) { ++answers; }).ok());
  EXPECT_EQ(answers, 3);
  EXPECT_EQ(inner.calls, 1);
}

TEST_F(JournalTest, an_evaluator_passes_on_only_what_is_on_disk_and_keeps_what_came_before_a_failure) {
  auto journal = Journal::open(file);
  ASSERT_TRUE(journal.ok());
  test::FunctionEvaluator inner([](const Rollout& r) { return test::bowl(r); });
  inner.fail_after = 5;
  JournaledEvaluator evaluator(inner, *journal);
  const auto all = rollouts(8);
  auto reader = Journal::open(file);
  ASSERT_TRUE(reader.ok());
  const auto status = evaluator.evaluate(all, [&](std::size_t i, const RolloutResult&) {
    EXPECT_TRUE(reader->find(key_of(all[i]))->has_value()) << "another process can read it already";
  });
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.error().code, Code::unavailable);
  EXPECT_EQ(reader->count("rollout").value(), 5);
}

}  // namespace
}  // namespace primo::study
