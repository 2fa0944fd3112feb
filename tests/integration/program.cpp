#include "program.hpp"

#include <fcntl.h>
#include <pty.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <fstream>
#include <sstream>

namespace swiftlet::tools {
namespace {

std::filesystem::path make_folder() {
  std::string name = (std::filesystem::temp_directory_path() / "swiftlet-test-XXXXXX").string();
  if (::mkdtemp(name.data()) == nullptr) throw std::runtime_error("no temporary folder");
  return name;
}

void send_to(const std::string& path, int descriptor) {
  const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  ::dup2(file, descriptor);
  ::close(file);
}

/// Starts a program; `connect` sets up its standard streams.
template <typename Connect>
pid_t start(const std::string& program, const std::vector<std::string>& arguments, const Connect& connect) {
  std::vector<std::string> words{program};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  argv.reserve(words.size() + 1);
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  const pid_t child = ::fork();
  if (child != 0) return child;
  connect();
  ::execvp(argv[0], argv.data());
  ::_exit(127);
}

/// Exit status, or minus the signal that ended it.
int wait_for(pid_t child) {
  int state = 0;
  ::waitpid(child, &state, 0);
  return WIFEXITED(state) ? WEXITSTATUS(state) : -WTERMSIG(state);
}

}  // namespace

Outcome run_program(const std::string& program, const std::vector<std::string>& arguments) {
  const std::filesystem::path folder = make_folder();
  const std::string out = folder / "out";
  const std::string err = folder / "err";
  const pid_t child = start(program, arguments, [&] {
    send_to(out, STDOUT_FILENO);
    send_to(err, STDERR_FILENO);
  });
  Outcome run;
  run.status = wait_for(child);
  run.out = read_text(out);
  run.err = read_text(err);
  std::filesystem::remove_all(folder);
  return run;
}

Outcome swiftlet_on_terminal(const std::vector<std::string>& arguments) {
  int ours = -1;
  int theirs = -1;
  if (::openpty(&ours, &theirs, nullptr, nullptr, nullptr) != 0) throw std::runtime_error("no terminal");
  const pid_t child = start(SWIFTLET_PROGRAM, arguments, [&] { ::dup2(theirs, STDERR_FILENO); });
  ::close(theirs);
  Outcome run;
  std::array<char, 4096> buffer{};
  for (ssize_t size = 0; (size = ::read(ours, buffer.data(), buffer.size())) > 0;) {  // fails when the child has ended
    run.err.append(buffer.data(), static_cast<std::size_t>(size));
  }
  ::close(ours);
  run.status = wait_for(child);
  return run;
}

Outcome swiftlet(const std::vector<std::string>& arguments) { return run_program(SWIFTLET_PROGRAM, arguments); }

std::string read_text(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

void write_text(const std::filesystem::path& path, const std::string& text) {
  std::ofstream file(path, std::ios::binary);
  file << text;
}

std::vector<Json> read_lines(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::vector<Json> lines;
  for (std::string line; std::getline(file, line);) lines.push_back(Json::parse(line));
  return lines;
}

testing::AssertionResult refused(const Outcome& run, int status, const std::vector<std::string>& words) {
  const auto failure = [&] {
    return testing::AssertionFailure() << "status " << run.status << ", standard error: " << run.err << " ";
  };
  if (run.status != status) return failure() << "status " << status << " expected";
  if (std::count(run.err.begin(), run.err.end(), '\n') != 1 || !run.err.ends_with('\n'))
    return failure() << "not one line";
  if (!run.out.empty()) return failure() << "standard output: " << run.out;
  for (const std::string& word : words) {
    if (run.err.find(word) == std::string::npos) return failure() << "'" << word << "' is missing";
  }
  return testing::AssertionSuccess();
}

FolderTest::FolderTest() : folder_(make_folder()) {}
FolderTest::~FolderTest() { std::filesystem::remove_all(folder_); }

std::vector<std::string> FolderTest::files() const {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder_)) names.push_back(entry.path().filename());
  std::sort(names.begin(), names.end());
  return names;
}

std::filesystem::path shared_folder() {
  const char* named = std::getenv("SWIFTLET_SHARED");
  const std::filesystem::path folder =
      named != nullptr ? std::filesystem::path(named) : std::filesystem::path(SWIFTLET_SOURCE_DIR) / "../shared";
  return std::filesystem::is_directory(folder) ? folder : std::filesystem::path();
}

}  // namespace swiftlet::tools
