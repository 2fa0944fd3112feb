#include "cli/output.hpp"

#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <set>
#include <span>

#include "cli/failure.hpp"
#include "map/file_io.hpp"

namespace swiftlet::tools {
namespace {

[[noreturn]] void refuse(const std::string& path, const std::string& why) {
  throw Failure{ExitStatus::kBadFile, path + ": cannot be written: " + why};
}

void check_output(const std::string& path) {
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(path, error);
  if (std::filesystem::is_directory(status)) refuse(path, "it is a folder");
  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status)) return;  // a device or a pipe
  std::filesystem::path folder = std::filesystem::path(path).parent_path();
  if (folder.empty()) folder = ".";
  if (!std::filesystem::is_directory(folder, error)) refuse(path, "there is no folder " + folder.string());
  if (::access(folder.c_str(), W_OK) != 0) refuse(path, std::strerror(errno));
}

void write_standard_output(std::string_view text) {
  const bool written = std::fwrite(text.data(), 1, text.size(), stdout) == text.size();
  if (!written || std::fflush(stdout) != 0) refuse("standard output", std::strerror(errno));
}

}  // namespace

void check_outputs(std::initializer_list<std::string_view> outputs, std::initializer_list<std::string_view> inputs) {
  std::set<std::string_view> seen;
  for (const std::string_view output : outputs) {
    if (output.empty()) continue;
    const std::string name = output == kStandardOutput ? "standard output" : std::string(output);
    if (!seen.insert(output).second) {
      throw Failure{ExitStatus::kUsage, name + " is named for two outputs; give each its own file"};
    }
    if (output == kStandardOutput) continue;
    for (const std::string_view input : inputs) {
      std::error_code missing;
      if (std::filesystem::equivalent(output, input, missing)) {
        throw Failure{ExitStatus::kUsage, name + " is an input; write to another file"};
      }
    }
    check_output(name);
  }
}

void write_output(std::string_view path, std::string_view text) {
  if (path.empty()) return;
  if (path == kStandardOutput) return write_standard_output(text);
  unwrap(write_file_atomically(std::string(path), std::as_bytes(std::span(text))));
}

void LineOutput::write_line(std::string_view line) {
  if (path_ == kStandardOutput) {
    write_standard_output(std::string(line) + '\n');
  } else {
    pending_.append(line).push_back('\n');
  }
}

void LineOutput::close() {
  if (path_ != kStandardOutput) write_output(path_, pending_);
}

}  // namespace swiftlet::tools
