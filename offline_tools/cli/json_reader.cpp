#include "cli/json_reader.hpp"

#include <algorithm>

#include "cli/failure.hpp"
#include "map/file_io.hpp"

namespace swiftlet::tools {

Json parse_json(const std::string& path, std::string_view text, std::size_t first_line) {
  try {
    return Json::parse(text);
  } catch (const Json::parse_error& error) {
    const std::size_t offset = std::min(error.byte, text.size());
    const auto lines = std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(offset), '\n');
    throw Failure{ExitStatus::kBadFile, path + ":" + std::to_string(first_line + static_cast<std::size_t>(lines)) +
                                            ": not valid JSON" + (offset == text.size() ? " (it ends too early)" : "")};
  } catch (const Json::out_of_range&) {
    throw Failure{ExitStatus::kBadFile, path + ":" + std::to_string(first_line) + ": a number is out of range"};
  }
}

Json load_json(const std::string& path, const std::string& format) {
  const std::vector<std::byte> bytes = unwrap(read_file(path));
  if (bytes.empty()) throw Failure{ExitStatus::kBadFile, path + ": is empty; a " + format + " is needed"};
  return parse_json(path, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

void JsonReader::refuse(const std::string& what) const { throw Failure{ExitStatus::kBadFile, where_ + ": " + what}; }

void JsonReader::check_format(const Json& json, const std::string& format) const {
  if (!json.is_object()) refuse("is not a JSON object");
  if (member(json, "format") != format) refuse("'format' is not \"" + format + "\"");
}

const Json& JsonReader::member(const Json& json, const std::string& key) const {
  if (!json.is_object() || !json.contains(key)) refuse("'" + key + "' is missing");
  return json[key];
}

double JsonReader::number(const Json& json, const std::string& what) const {
  if (!json.is_number()) refuse("'" + what + "' is not a number");
  return json.get<double>();
}

bool JsonReader::boolean(const Json& json, const std::string& what) const {
  if (!json.is_boolean()) refuse("'" + what + "' is neither true nor false");
  return json.get<bool>();
}

std::string JsonReader::word(const Json& json, const std::string& what) const {
  if (!json.is_string()) refuse("'" + what + "' is not a string");
  return json.get<std::string>();
}

const Json& JsonReader::list(const Json& json, const std::string& what) const {
  if (!json.is_array()) refuse("'" + what + "' is not a list");
  return json;
}

std::vector<double> JsonReader::numbers(const Json& json, const std::string& what) const {
  if (!json.is_array()) refuse("'" + what + "' is not a list of numbers");
  std::vector<double> list;
  for (const Json& item : json) list.push_back(number(item, what));
  return list;
}

std::vector<double> JsonReader::numbers(const Json& json, const std::string& what, std::size_t count) const {
  std::vector<double> list = numbers(json, what);
  if (list.size() != count) {
    refuse("'" + what + "' has " + std::to_string(list.size()) + " numbers, not " + std::to_string(count));
  }
  return list;
}

}  // namespace swiftlet::tools
