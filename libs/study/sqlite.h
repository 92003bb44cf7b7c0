// SQLite with errors as values. Private to libs/study.
#pragma once

#include <sqlite3.h>

#include <cstdint>
#include <string>
#include <string_view>

#include "core/result.h"

namespace primo::study::sqlite {

/// What SQLite says of the last failure, with the code that fits it: busy or unwritable is unavailable, damage is data.
Error error_of(sqlite3* database, int code, const std::string& file, const std::string& what);

Status execute(sqlite3* database, const std::string& file, const char* sql);

/// A prepared statement. Parameters are bound in order; step() says whether there is a row.
class Statement {
 public:
  static Result<Statement> prepare(sqlite3* database, const std::string& file, const char* sql);
  Statement(Statement&& other) noexcept;
  Statement& operator=(Statement&&) = delete;
  ~Statement();

  Statement& bind(std::int64_t value);
  Statement& bind(int value) { return bind(static_cast<std::int64_t>(value)); }
  Statement& bind(double value);
  Statement& bind(std::string_view value);
  Result<bool> step();
  /// Runs a statement without rows and makes it ready for the next values.
  Status run();
  void reset();

  std::string text(int column) const;
  std::int64_t integer(int column) const { return sqlite3_column_int64(statement_, column); }
  double real(int column) const { return sqlite3_column_double(statement_, column); }

 private:
  Statement(sqlite3* database, std::string file, sqlite3_stmt* statement)
      : database_(database), file_(std::move(file)), statement_(statement) {}
  sqlite3* database_;
  std::string file_;
  sqlite3_stmt* statement_;
  int next_ = 1;
};

/// BEGIN IMMEDIATE; rolled back unless committed.
class Transaction {
 public:
  static Result<Transaction> begin(sqlite3* database, const std::string& file);
  Transaction(Transaction&& other) noexcept;
  Transaction& operator=(Transaction&&) = delete;
  ~Transaction();
  Status commit();

 private:
  Transaction(sqlite3* database, std::string file) : database_(database), file_(std::move(file)) {}
  sqlite3* database_;
  std::string file_;
};

}  // namespace primo::study::sqlite
