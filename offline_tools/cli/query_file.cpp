#include "cli/query_file.hpp"

#include <algorithm>
#include <array>
#include <string_view>

#include "cli/failure.hpp"
#include "cli/text.hpp"
#include "map/file_io.hpp"

namespace swiftlet::tools {
namespace {

constexpr std::array<std::string_view, 6> kColumns{"x0", "y0", "z0", "x1", "y1", "z1"};

/// Where a fault lies: "file:line: ".
std::string place(const std::string& path, std::size_t line) { return path + ":" + std::to_string(line) + ": "; }

/// The fields of a row; a comma between double quotes parts none. Quotes around a field are taken off.
std::vector<std::string_view> split_row(std::string_view row) {
  std::vector<std::string_view> fields;
  bool quoted = false;
  std::size_t begin = 0;
  for (std::size_t i = 0; i <= row.size(); ++i) {
    if (i < row.size() && row[i] == '"') quoted = !quoted;
    if (i < row.size() && (row[i] != ',' || quoted)) continue;
    std::string_view field = trimmed(row.substr(begin, i - begin));
    if (field.size() >= 2 && field.front() == '"' && field.back() == '"') field = field.substr(1, field.size() - 2);
    fields.push_back(field);
    begin = i + 1;
  }
  return fields;
}

std::array<std::size_t, 6> find_columns(const std::string& where, const std::vector<std::string_view>& header) {
  std::array<std::size_t, 6> columns{};
  for (std::size_t i = 0; i < kColumns.size(); ++i) {
    const auto found = std::find(header.begin(), header.end(), kColumns[i]);
    if (found == header.end()) {
      throw Failure{ExitStatus::kBadFile,
                    where + "no column '" + std::string(kColumns[i]) + "' in the header; x0,y0,z0,x1,y1,z1 are needed"};
    }
    columns[i] = static_cast<std::size_t>(found - header.begin());
  }
  return columns;
}

Query parse_row(const std::string& where, const std::vector<std::string_view>& fields,
                const std::array<std::size_t, 6>& columns, std::size_t width) {
  if (fields.size() != width) {
    throw Failure{ExitStatus::kBadFile,
                  where + std::to_string(fields.size()) + " fields, but the header has " + std::to_string(width)};
  }
  Query query;
  for (std::size_t i = 0; i < kColumns.size(); ++i) {
    const std::string_view field = fields[columns[i]];
    const std::optional<double> number = parse_number(field);
    if (!number) {
      throw Failure{ExitStatus::kBadFile,
                    where + "'" + std::string(field) + "' in column " + std::string(kColumns[i]) + " is not a number"};
    }
    (i < 3 ? query.start : query.goal)[static_cast<Eigen::Index>(i % 3)] = *number;
  }
  return query;
}

}  // namespace

std::vector<Query> load_queries(const std::string& path) {
  const std::vector<std::byte> bytes = unwrap(read_file(path));
  std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";
  if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());

  std::vector<Query> queries;
  std::array<std::size_t, 6> columns{};
  std::size_t width = 0;  // of the header; 0 until it is found
  for (std::size_t line = 1; !text.empty(); ++line) {
    const std::size_t end = text.find('\n');
    const std::string_view row = text.substr(0, end);
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    const std::vector<std::string_view> fields = split_row(row);
    if (fields.size() == 1 && fields[0].empty()) continue;
    if (width == 0) {
      columns = find_columns(place(path, line), fields);
      width = fields.size();
    } else {
      queries.push_back(parse_row(place(path, line), fields, columns, width));
    }
  }
  if (width == 0) throw Failure{ExitStatus::kBadFile, path + ": is empty; a header x0,y0,z0,x1,y1,z1 is needed"};
  return queries;
}

}  // namespace swiftlet::tools
