#pragma once
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace swiftlet::tools {

using Json = nlohmann::ordered_json;

/// What a run of the program left behind.
struct Outcome {
  int status = -1;  ///< exit status, or minus the signal that ended it
  std::string out;
  std::string err;
};

/// Runs the program `swiftlet` of this build with these arguments.
Outcome swiftlet(const std::vector<std::string>& arguments);
/// The same with standard error on a terminal: `err` is all that was sent there.
Outcome swiftlet_on_terminal(const std::vector<std::string>& arguments);
/// Runs any program, found by path or by name.
Outcome run_program(const std::string& program, const std::vector<std::string>& arguments);

std::string read_text(const std::filesystem::path& path);
void write_text(const std::filesystem::path& path, const std::string& text);
std::vector<Json> read_lines(const std::filesystem::path& path);

/// Passes when the run ended with `status` and said so in exactly one line on standard error that holds every word, and
/// nothing on standard output.
testing::AssertionResult refused(const Outcome& run, int status, const std::vector<std::string>& words);

/// An empty folder of one test, removed at its end.
class FolderTest : public testing::Test {
 protected:
  FolderTest();
  ~FolderTest() override;
  FolderTest(const FolderTest&) = delete;
  FolderTest& operator=(const FolderTest&) = delete;

  [[nodiscard]] std::string path(const std::string& name) const { return (folder_ / name).string(); }
  /// Names of all files in the folder, sorted.
  [[nodiscard]] std::vector<std::string> files() const;

 private:
  std::filesystem::path folder_;
};

/// The folder with reference maps and cases beside the project, or empty where there is none: SWIFTLET_SHARED in the
/// environment, else ../shared.
std::filesystem::path shared_folder();

}  // namespace swiftlet::tools
