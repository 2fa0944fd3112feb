#pragma once
#include <initializer_list>
#include <string>
#include <string_view>

namespace swiftlet::tools {

/// What `-` stands for among output files.
inline constexpr std::string_view kStandardOutput = "-";

/// Refuses, before any work is done, outputs that plainly cannot be written, that are named twice or that would replace
/// an input; empty names are files that were not asked for. Throws Failure.
void check_outputs(std::initializer_list<std::string_view> outputs, std::initializer_list<std::string_view> inputs);

/// Writes the whole output: a file beside and then renamed, `-` as standard output; an empty name is skipped. Throws
/// Failure.
void write_output(std::string_view path, std::string_view text);

/// A line a call for standard output (`-`), all at once on `close` for a file, so that a failure leaves no half file.
class LineOutput {
 public:
  explicit LineOutput(std::string path) : path_(std::move(path)) {}
  void write_line(std::string_view line);
  void close();

 private:
  std::string path_;
  std::string pending_;
};

}  // namespace swiftlet::tools
