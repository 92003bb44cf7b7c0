#include "study/journal.h"

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <fstream>

#include "core/hash.h"
#include "study/json_io.h"
#include "study/sqlite.h"

namespace primo::study {
namespace {

namespace fs = std::filesystem;
using sqlite::Statement;
using sqlite::Transaction;

constexpr int kApplicationId = 0x5072696d;  // "Prim"

/// Up to this size a journal is checked whole when it is opened, in about a second; every answer carries a digest of
/// its own, which is checked when it is read.
constexpr std::uintmax_t kMostCheckedBytes = 256u << 20;

constexpr const char* kSchema = R"sql(
  PRAGMA application_id = 1349675373;
  PRAGMA user_version = 3;
  CREATE TABLE answers (key TEXT PRIMARY KEY, kind TEXT NOT NULL, reply TEXT NOT NULL, digest TEXT NOT NULL, seconds REAL NOT NULL);
  CREATE TABLE evaluations (part TEXT, round INTEGER, algorithm TEXT, restart INTEGER, generation INTEGER, candidate INTEGER, gamma REAL,
    successes INTEGER, final_pose INTEGER, scenarios INTEGER, x TEXT, PRIMARY KEY (part, round, algorithm, restart, generation, candidate))
    WITHOUT ROWID;
  CREATE TABLE finalists (part TEXT, round INTEGER, algorithm TEXT, restart INTEGER, kind TEXT, gamma REAL, successes INTEGER, trials INTEGER,
    chosen INTEGER, x TEXT, PRIMARY KEY (part, round, algorithm, restart, kind)) WITHOUT ROWID;
  CREATE TABLE sensitivities (part TEXT, round INTEGER, entry INTEGER, name TEXT, log INTEGER, side INTEGER, x REAL, gamma REAL,
    successes INTEGER, trials INTEGER, PRIMARY KEY (part, round, entry, side)) WITHOUT ROWID;
  CREATE TABLE timings (id INTEGER PRIMARY KEY, part TEXT, round INTEGER, stage TEXT, seconds REAL, rollouts INTEGER);
)sql";
static_assert(kApplicationId == 1349675373 && Journal::kVersion == 3, "the schema states both as literals");

/// Guards a row against bytes that changed on the disk: SQLite has no checksums of its own.
std::string row_digest(const std::string& key, const std::string& kind, const std::string& reply) {
  return hex(Hasher().add(key).add(kind).add(reply).value());
}

Error damaged(const fs::path& file, const std::string& what) {
  return {Code::data, file.string() + ": " + what +
                          "; the journal is left as it is: move the study's directory away to start anew"};
}

/// SQLite takes an empty file for a new database, and a file that is shorter than its header says only when it reads so
/// far.
Status check_header(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) return Error{Code::unavailable, file.string() + ": the journal cannot be read: " + std::strerror(errno)};
  std::array<char, 100> header{};
  in.read(header.data(), header.size());
  if (in.gcount() < 100 || std::string_view(header.data(), 16) != std::string_view("SQLite format 3\0", 16)) {
    return damaged(file, "is not a journal (no SQLite header)");
  }
  return success();
}

Result<std::int64_t> pragma(sqlite3* database, const fs::path& file, const char* sql) {
  PRIMO_ASSIGN(Statement statement, Statement::prepare(database, file.string(), sql));
  PRIMO_ASSIGN(const bool row, statement.step());
  return row ? statement.integer(0) : 0;
}

Status check_integrity(sqlite3* database, const fs::path& file) {
  std::error_code ignored;
  if (fs::file_size(file, ignored) > kMostCheckedBytes) return success();
  PRIMO_ASSIGN(Statement statement, Statement::prepare(database, file.string(), "PRAGMA integrity_check(1)"));
  PRIMO_ASSIGN(const bool row, statement.step());
  if (!row || statement.text(0) != "ok")
    return damaged(file, "is damaged (" + (row ? statement.text(0) : "no answer") + ")");
  return success();
}

Status check_version(sqlite3* database, const fs::path& file) {
  PRIMO_ASSIGN(const auto application, pragma(database, file, "PRAGMA application_id"));
  if (application != kApplicationId) return damaged(file, "is a database, but not a study's journal");
  PRIMO_ASSIGN(const auto version, pragma(database, file, "PRAGMA user_version"));
  if (version != Journal::kVersion) {
    return damaged(file, "has format version " + std::to_string(version) + ", this program reads version " +
                             std::to_string(Journal::kVersion));
  }
  return success();
}

/// Creates the journal under another name and links it into place, so that no one ever sees a journal without its
/// tables.
Status create(const fs::path& file) {
  static std::atomic<int> attempts{0};
  const fs::path temporary = file.string() + ".new." + std::to_string(::getpid()) + "." + std::to_string(attempts++);
  std::error_code ignored;
  fs::remove(temporary, ignored);
  sqlite3* database = nullptr;
  const int code = sqlite3_open_v2(temporary.c_str(), &database, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE, nullptr);
  std::unique_ptr<sqlite3, decltype(&sqlite3_close_v2)> owner(database, &sqlite3_close_v2);
  Status status = code == SQLITE_OK
                      ? sqlite::execute(database, file.string(),
                                        (std::string("BEGIN;") + kSchema + "COMMIT; PRAGMA journal_mode=WAL;").c_str())
                      : sqlite::error_of(database, code, file.string(), "the journal cannot be created");
  owner.reset();
  if (status.ok() && ::link(temporary.c_str(), file.c_str()) != 0 && errno != EEXIST) {
    status = Error{Code::unavailable, file.string() + ": the journal cannot be created: " + std::strerror(errno)};
  }
  fs::remove(temporary, ignored);
  return status;
}

std::string encode_x(const std::vector<double>& x) { return symbols::dump(json::doubles(x)); }

Result<std::vector<double>> decode_x(const std::string& text) {
  return json::decode(text, "log ρ", [](const json::Json& at) {
    if (!at.is_array()) throw json::Malformed{"must be a list"};
    std::vector<double> x;
    for (const auto& value : at) x.push_back(json::to_double(value, "log ρ"));
    return x;
  });
}

}  // namespace

void Journal::Closer::operator()(sqlite3* database) const { sqlite3_close_v2(database); }

Journal::Journal(fs::path file, sqlite3* database) : file_(std::move(file)), database_(database) {}
Journal::Journal(Journal&&) noexcept = default;
Journal& Journal::operator=(Journal&&) noexcept = default;
Journal::~Journal() = default;

Result<Journal> Journal::open(const fs::path& file) {
  std::error_code ignored;
  if (!fs::exists(file, ignored)) PRIMO_TRY(create(file));
  return open_file(file);
}

Result<Journal> Journal::open_existing(const fs::path& file) {
  std::error_code ignored;
  if (!fs::exists(file, ignored))
    return Error{Code::config, file.string() + ": there is no journal; is this a study's directory?"};
  return open_file(file);
}

Result<Journal> Journal::open_file(const fs::path& file) {
  PRIMO_TRY(check_header(file));
  sqlite3* database = nullptr;
  const int code = sqlite3_open_v2(file.c_str(), &database, SQLITE_OPEN_READWRITE | SQLITE_OPEN_NOMUTEX, nullptr);
  Journal journal(file, database);
  if (code != SQLITE_OK) return sqlite::error_of(database, code, file.string(), "the journal cannot be opened");
  sqlite3_busy_timeout(database, 20000);
  PRIMO_TRY(check_version(database, file));
  PRIMO_TRY(sqlite::execute(database, file.string(), "PRAGMA journal_mode=WAL"));
  PRIMO_TRY(sqlite::execute(database, file.string(), "PRAGMA synchronous=FULL"));
  PRIMO_TRY(check_integrity(database, file));
  return journal;
}

Result<std::optional<std::string>> Journal::find(const std::string& key) {
  PRIMO_ASSIGN(Statement statement, Statement::prepare(database_.get(), file_.string(),
                                                       "SELECT kind, reply, digest FROM answers WHERE key = ?"));
  statement.bind(key);
  PRIMO_ASSIGN(const bool row, statement.step());
  if (!row) return std::optional<std::string>();
  std::string reply = statement.text(1);
  if (row_digest(key, statement.text(0), reply) != statement.text(2)) {
    return damaged(file_, "the answer " + key + " is damaged (its digest does not match)");
  }
  return std::optional<std::string>(std::move(reply));
}

Result<std::vector<std::string>> Journal::record(std::span<const Answer> answers) {
  const std::string name = file_.string();
  PRIMO_ASSIGN(Transaction transaction, Transaction::begin(database_.get(), name));
  PRIMO_ASSIGN(Statement insert,
               Statement::prepare(database_.get(), name,
                                  "INSERT INTO answers VALUES (?, ?, ?, ?, ?) ON CONFLICT (key) DO NOTHING"));
  std::vector<std::string> replies;
  for (const auto& answer : answers) {
    insert.bind(answer.key).bind(answer.kind).bind(answer.reply);
    insert.bind(row_digest(answer.key, answer.kind, answer.reply)).bind(answer.seconds);
    PRIMO_TRY(insert.run());
    if (sqlite3_changes(database_.get()) == 1) {
      replies.push_back(answer.reply);
      continue;
    }
    PRIMO_ASSIGN(auto first, find(answer.key));
    PRIMO_CHECK(first.has_value(), "an answer that conflicts is there");
    replies.push_back(std::move(*first));
  }
  PRIMO_TRY(transaction.commit());
  return replies;
}

Status Journal::record_evaluations(std::span<const EvaluationRecord> evaluations) {
  const std::string name = file_.string();
  PRIMO_ASSIGN(Transaction transaction, Transaction::begin(database_.get(), name));
  PRIMO_ASSIGN(Statement insert,
               Statement::prepare(database_.get(), name,
                                  "INSERT OR REPLACE INTO evaluations VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)"));
  for (const auto& e : evaluations) {
    insert.bind(e.part).bind(e.round).bind(e.algorithm).bind(e.restart).bind(e.generation).bind(e.index).bind(e.gamma);
    insert.bind(e.successes).bind(e.final_pose).bind(e.scenarios).bind(encode_x(e.x));
    PRIMO_TRY(insert.run());
  }
  return transaction.commit();
}

Result<std::vector<EvaluationRecord>> Journal::evaluations() {
  PRIMO_ASSIGN(Statement rows,
               Statement::prepare(database_.get(), file_.string(),
                                  "SELECT part, round, algorithm, restart, generation, candidate, gamma, successes, "
                                  "final_pose, scenarios, x FROM evaluations "
                                  "ORDER BY part, round, algorithm, restart, generation, candidate"));
  std::vector<EvaluationRecord> found;
  while (true) {
    PRIMO_ASSIGN(const bool row, rows.step());
    if (!row) return found;
    EvaluationRecord e;
    e.part = rows.text(0);
    e.round = static_cast<int>(rows.integer(1));
    e.algorithm = rows.text(2);
    e.restart = static_cast<int>(rows.integer(3));
    e.generation = static_cast<int>(rows.integer(4));
    e.index = static_cast<int>(rows.integer(5));
    e.gamma = rows.real(6);
    e.successes = static_cast<int>(rows.integer(7));
    e.final_pose = static_cast<int>(rows.integer(8));
    e.scenarios = static_cast<int>(rows.integer(9));
    PRIMO_ASSIGN(e.x, decode_x(rows.text(10)));
    found.push_back(std::move(e));
  }
}

Status Journal::record_finalists(std::span<const FinalistRecord> finalists) {
  const std::string name = file_.string();
  PRIMO_ASSIGN(Transaction transaction, Transaction::begin(database_.get(), name));
  PRIMO_ASSIGN(Statement insert,
               Statement::prepare(database_.get(), name,
                                  "INSERT OR REPLACE INTO finalists VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?)"));
  for (const auto& f : finalists) {
    insert.bind(f.part).bind(f.round).bind(f.algorithm).bind(f.restart).bind(f.kind).bind(f.gamma);
    insert.bind(f.success.successes).bind(f.success.trials).bind(f.chosen ? 1 : 0).bind(encode_x(f.x));
    PRIMO_TRY(insert.run());
  }
  return transaction.commit();
}

Result<std::vector<FinalistRecord>> Journal::finalists() {
  PRIMO_ASSIGN(Statement rows,
               Statement::prepare(database_.get(), file_.string(),
                                  "SELECT part, round, algorithm, restart, kind, gamma, successes, trials, chosen, x "
                                  "FROM finalists ORDER BY part, round, algorithm, restart, kind"));
  std::vector<FinalistRecord> found;
  while (true) {
    PRIMO_ASSIGN(const bool row, rows.step());
    if (!row) return found;
    FinalistRecord f;
    f.part = rows.text(0);
    f.round = static_cast<int>(rows.integer(1));
    f.algorithm = rows.text(2);
    f.restart = static_cast<int>(rows.integer(3));
    f.kind = rows.text(4);
    f.gamma = rows.real(5);
    f.success = {rows.integer(6), rows.integer(7)};
    f.chosen = rows.integer(8) != 0;
    PRIMO_ASSIGN(f.x, decode_x(rows.text(9)));
    found.push_back(std::move(f));
  }
}

Status Journal::record_sensitivities(std::span<const SensitivityRecord> sensitivities) {
  const std::string name = file_.string();
  PRIMO_ASSIGN(Transaction transaction, Transaction::begin(database_.get(), name));
  PRIMO_ASSIGN(Statement insert,
               Statement::prepare(database_.get(), name,
                                  "INSERT OR REPLACE INTO sensitivities VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?)"));
  for (const auto& s : sensitivities) {
    for (std::size_t side = 0; side < s.x.size(); ++side) {
      insert.bind(s.part).bind(s.round).bind(s.index).bind(s.entry).bind(s.log ? 1 : 0).bind(static_cast<int>(side));
      insert.bind(s.x[side]).bind(s.gamma[side]).bind(s.success[side].successes).bind(s.success[side].trials);
      PRIMO_TRY(insert.run());
    }
  }
  return transaction.commit();
}

Result<std::vector<SensitivityRecord>> Journal::sensitivities() {
  PRIMO_ASSIGN(Statement rows,
               Statement::prepare(database_.get(), file_.string(),
                                  "SELECT part, round, entry, name, log, side, x, gamma, successes, trials FROM "
                                  "sensitivities ORDER BY part, round, entry, side"));
  std::vector<SensitivityRecord> found;
  while (true) {
    PRIMO_ASSIGN(const bool row, rows.step());
    if (!row) return found;
    const auto side = static_cast<std::size_t>(rows.integer(5));
    if (side == 0) found.emplace_back();
    if (found.empty() || side >= found.back().x.size()) return damaged(file_, "has sensitivities out of order");
    SensitivityRecord& s = found.back();
    s.part = rows.text(0);
    s.round = static_cast<int>(rows.integer(1));
    s.index = static_cast<int>(rows.integer(2));
    s.entry = rows.text(3);
    s.log = rows.integer(4) != 0;
    s.x[side] = rows.real(6);
    s.gamma[side] = rows.real(7);
    s.success[side] = {rows.integer(8), rows.integer(9)};
  }
}

Status Journal::record_timing(const TimingRecord& timing) {
  PRIMO_ASSIGN(
      Statement insert,
      Statement::prepare(database_.get(), file_.string(),
                         "INSERT INTO timings (part, round, stage, seconds, rollouts) VALUES (?, ?, ?, ?, ?)"));
  return insert.bind(timing.part)
      .bind(timing.round)
      .bind(timing.stage)
      .bind(timing.seconds)
      .bind(timing.rollouts)
      .run();
}

Result<std::vector<TimingRecord>> Journal::timings() {
  PRIMO_ASSIGN(Statement rows,
               Statement::prepare(database_.get(), file_.string(),
                                  "SELECT part, round, stage, seconds, rollouts FROM timings ORDER BY id"));
  std::vector<TimingRecord> found;
  while (true) {
    PRIMO_ASSIGN(const bool row, rows.step());
    if (!row) return found;
    found.push_back({rows.text(0), static_cast<int>(rows.integer(1)), rows.text(2), rows.real(3), rows.integer(4)});
  }
}

Result<std::int64_t> Journal::count(const std::string& kind) {
  PRIMO_ASSIGN(Statement statement,
               Statement::prepare(database_.get(), file_.string(), "SELECT COUNT(*) FROM answers WHERE kind = ?"));
  statement.bind(kind);
  PRIMO_ASSIGN([[maybe_unused]] const bool row, statement.step());
  return statement.integer(0);
}

fs::path journal_file(const fs::path& study_directory) { return study_directory / "journal.db"; }

}  // namespace primo::study
