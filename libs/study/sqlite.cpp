#include "study/sqlite.h"

#include <utility>

namespace primo::study::sqlite {

Error error_of(sqlite3* database, int code, const std::string& file, const std::string& what) {
  const std::string detail = database != nullptr ? sqlite3_errmsg(database) : sqlite3_errstr(code);
  const std::string message = file + ": " + what + ": " + detail;
  switch (code & 0xff) {
    case SQLITE_CORRUPT:
    case SQLITE_NOTADB:
    case SQLITE_FORMAT:
      return {
          Code::data,
          message + "; the journal is damaged, and is left as it is: move the study's directory away to start anew"};
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      return {Code::unavailable, message + "; another process holds the journal"};
    case SQLITE_FULL:
      return {Code::unavailable, message + "; free some disk space and start again"};
    case SQLITE_READONLY:
    case SQLITE_PERM:
    case SQLITE_CANTOPEN:
    case SQLITE_IOERR:
      return {Code::unavailable, message + "; the study's directory must be writable"};
    default:
      return {Code::failed, message};
  }
}

Status execute(sqlite3* database, const std::string& file, const char* sql) {
  const int code = sqlite3_exec(database, sql, nullptr, nullptr, nullptr);
  if (code != SQLITE_OK) return error_of(database, code, file, "the journal refused a statement");
  return success();
}

Result<Statement> Statement::prepare(sqlite3* database, const std::string& file, const char* sql) {
  sqlite3_stmt* statement = nullptr;
  const int code = sqlite3_prepare_v2(database, sql, -1, &statement, nullptr);
  if (code != SQLITE_OK) return error_of(database, code, file, "the journal cannot be read");
  return Statement(database, file, statement);
}

Statement::Statement(Statement&& other) noexcept
    : database_(other.database_),
      file_(std::move(other.file_)),
      statement_(std::exchange(other.statement_, nullptr)),
      next_(other.next_) {}

Statement::~Statement() { sqlite3_finalize(statement_); }

Statement& Statement::bind(std::int64_t value) {
  PRIMO_CHECK(sqlite3_bind_int64(statement_, next_++, value) == SQLITE_OK, "bind");
  return *this;
}

Statement& Statement::bind(double value) {
  PRIMO_CHECK(sqlite3_bind_double(statement_, next_++, value) == SQLITE_OK, "bind");
  return *this;
}

Statement& Statement::bind(std::string_view value) {
  PRIMO_CHECK(
      sqlite3_bind_text64(statement_, next_++, value.data(), value.size(), SQLITE_TRANSIENT, SQLITE_UTF8) == SQLITE_OK,
      "bind");
  return *this;
}

Result<bool> Statement::step() {
  const int code = sqlite3_step(statement_);
  if (code == SQLITE_ROW) return true;
  if (code == SQLITE_DONE) return false;
  return error_of(database_, code, file_, "the journal refused a statement");
}

Status Statement::run() {
  PRIMO_ASSIGN([[maybe_unused]] const bool row, step());
  reset();
  return success();
}

void Statement::reset() {
  sqlite3_reset(statement_);
  next_ = 1;
}

std::string Statement::text(int column) const {
  const auto* bytes = reinterpret_cast<const char*>(sqlite3_column_text(statement_, column));
  return bytes == nullptr ? std::string()
                          : std::string(bytes, static_cast<std::size_t>(sqlite3_column_bytes(statement_, column)));
}

Result<Transaction> Transaction::begin(sqlite3* database, const std::string& file) {
  PRIMO_TRY(execute(database, file, "BEGIN IMMEDIATE"));
  return Transaction(database, file);
}

Transaction::Transaction(Transaction&& other) noexcept
    : database_(std::exchange(other.database_, nullptr)), file_(std::move(other.file_)) {}

Transaction::~Transaction() {
  if (database_ != nullptr) sqlite3_exec(database_, "ROLLBACK", nullptr, nullptr, nullptr);
}

Status Transaction::commit() {
  PRIMO_TRY(execute(database_, file_, "COMMIT"));
  database_ = nullptr;
  return success();
}

}  // namespace primo::study::sqlite
