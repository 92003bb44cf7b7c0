// Literals in JSON: ["on","X","Y"], negated ["not","on","X","Y"]; a function's value ["size","X",3] and its ranges
// [">=","size","X",3] and ["<=","size","X",3]; and the strict reading of JSON that experiences and rules share.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "core/result.h"
#include "symbols/literal.h"

namespace primo::symbols {

using Json = nlohmann::ordered_json;

inline constexpr std::size_t kMaxJsonBytes = 64u << 20;
inline constexpr std::size_t kMaxNameBytes = 128;  ///< a predicate's or term's name

/// Parses a whole text. Errors (data): malformed, too large, nested deeper than `max_depth`, a key twice in one object.
Result<Json> parse_json(const std::string& text, int max_depth);

/// Whether `name` may name a predicate, an object or a variable: letters, digits and _ - . : / only, and not "not".
bool is_name(const std::string& name);

Json literal_to_json(const Literal& literal);
/// Error (data): not an array of names, an empty one, a double negation, a range without its number, or too many
/// arguments.
Result<Literal> literal_from_json(const Json& json);

/// The object's keys must all be among `known`; error (data) naming the unknown key and the known ones.
Status check_keys(const Json& object, std::initializer_list<const char*> known);

/// The JSON text on one line; bytes that are not UTF-8 become U+FFFD.
std::string dump(const Json& json);

}  // namespace primo::symbols
