#pragma once
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>

// What the tests of the report pages share: reading a page back, and opening it in a browser.
namespace swiftlet::tools::test {

inline constexpr const char* kWithWebGl = "--use-angle=swiftshader --enable-unsafe-swiftshader";
inline constexpr const char* kWithoutWebGl = "--disable-gpu --disable-3d-apis";

/// The text between the first `from` and the next `to` after it.
inline std::string between(const std::string& text, const std::string& from, const std::string& to) {
  const std::size_t begin = text.find(from);
  if (begin == std::string::npos) return {};
  const std::size_t end = text.find(to, begin + from.size());
  return text.substr(begin + from.size(), end - begin - from.size());
}

inline nlohmann::ordered_json data_of(const std::string& html) {
  return nlohmann::ordered_json::parse(between(html, "<script type=\"application/json\" id=\"report\">", "</script>"));
}

inline std::size_t occurrences(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

inline void expect_nothing_from_outside(const std::string& html) {
  EXPECT_NE(html.find("default-src 'none'"), std::string::npos);
  for (const char* link : {"src=\"http", "href=\"http", "<link", "@import", "url(http"}) {
    EXPECT_EQ(html.find(link), std::string::npos) << link;
  }
}

/// A folder of its own for one browser, gone with the object.
class TemporaryFolder {
 public:
  TemporaryFolder() : path_((std::filesystem::temp_directory_path() / "report_test.XXXXXX").string()) {
    if (mkdtemp(path_.data()) == nullptr) throw std::runtime_error("mkdtemp " + path_);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  ~TemporaryFolder() { std::filesystem::remove_all(path_); }
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  std::string path_;
};

inline bool has_browser() { return std::system("command -v chromium >/dev/null 2>&1") == 0; }

/// The markup that the page's script has made in a browser.
inline std::string opened_in_browser(const std::string& html, const std::string& flags) {
  const TemporaryFolder folder;
  std::ofstream(folder.path() + "/report.html") << html;
  const std::string command = "timeout 60 chromium --headless=new --no-sandbox --virtual-time-budget=5000 --dump-dom " +
                              flags + " --user-data-dir=" + folder.path() + "/profile file://" + folder.path() +
                              "/report.html 2>/dev/null";
  const std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen(command.c_str(), "r"), pclose);
  std::string dom;
  std::array<char, 4096> buffer{};
  while (const std::size_t count = std::fread(buffer.data(), 1, buffer.size(), pipe.get())) {
    dom.append(buffer.data(), count);
  }
  return between(dom, "<div id=\"page\">", "<footer>");
}

}  // namespace swiftlet::tools::test
