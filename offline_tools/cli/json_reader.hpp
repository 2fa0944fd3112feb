#pragma once
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "cli/json.hpp"

namespace swiftlet::tools {

/// The value that the text holds. Throws Failure (kBadFile) naming file and line. `first_line` is the number of the
/// text's first line in the file.
Json parse_json(const std::string& path, std::string_view text, std::size_t first_line = 1);

/// The whole file as one value. Throws Failure (kBadFile); an empty file is told that a `format` is needed.
Json load_json(const std::string& path, const std::string& format);

/// Takes values out of a document of a known format. Every fault throws Failure (kBadFile) that names the place.
class JsonReader {
 public:
  /// `where` is "file" or "file:line".
  explicit JsonReader(std::string where) : where_(std::move(where)) {}

  [[noreturn]] void refuse(const std::string& what) const;
  /// `json` is an object whose `format` is this one.
  void check_format(const Json& json, const std::string& format) const;
  const Json& member(const Json& json, const std::string& key) const;

  // `what` names the value in the fault.
  double number(const Json& json, const std::string& what) const;
  bool boolean(const Json& json, const std::string& what) const;
  std::string word(const Json& json, const std::string& what) const;
  /// Any number of items.
  const Json& list(const Json& json, const std::string& what) const;
  std::vector<double> numbers(const Json& json, const std::string& what) const;
  /// Exactly `count` of them.
  std::vector<double> numbers(const Json& json, const std::string& what, std::size_t count) const;

 private:
  std::string where_;
};

}  // namespace swiftlet::tools
