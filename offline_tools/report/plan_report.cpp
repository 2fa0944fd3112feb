#include "report/plan_report.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "report/page_template.hpp"
#include "swiftlet/version.hpp"

namespace swiftlet::tools {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMostBoxes = 400'000;  // 16 characters each

std::string escape_html(std::string_view text) {
  std::string escaped;
  for (const char character : text) {
    switch (character) {
      case '&':
        escaped += "&amp;";
        break;
      case '<':
        escaped += "&lt;";
        break;
      case '>':
        escaped += "&gt;";
        break;
      default:
        escaped += character;
    }
  }
  return escaped;
}

/// JSON that may stand inside a script element: no `<`, so neither an end tag nor a comment. Bytes that are not UTF-8
/// (a path may hold any) are replaced.
std::string script_json(const Json& json) {
  const std::string text = json.dump(-1, ' ', false, Json::error_handler_t::replace);
  std::string escaped;
  escaped.reserve(text.size());
  for (const char character : text) {
    if (character == '<') {
      escaped += "\\u003c";
    } else {
      escaped += character;
    }
  }
  return escaped;
}

void append_base64(std::string& text, std::uint32_t three_bytes) {
  constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  for (int shift = 18; shift >= 0; shift -= 6) text += kDigits[(three_bytes >> shift) & 63U];
}

/// Base64 of the six corners of every box as 16-bit little-endian integers: 12 bytes, so no padding.
std::string encode_boxes(std::span<const IntBox> boxes) {
  std::string text;
  text.reserve(boxes.size() * 16);
  for (const IntBox& box : boxes) {
    std::array<std::uint32_t, 12> bytes{};
    for (std::size_t i = 0; i < 6; ++i) {
      const std::uint32_t corner = i < 3 ? box.lo[i] : box.hi[i - 3];
      bytes[2 * i] = corner & 0xFFU;
      bytes[2 * i + 1] = corner >> 8U;
    }
    for (std::size_t i = 0; i < 12; i += 3) append_base64(text, bytes[i] << 16U | bytes[i + 1] << 8U | bytes[i + 2]);
  }
  return text;
}

std::uint64_t volume(const IntBox& box) {
  std::uint64_t product = 1;
  for (std::size_t axis = 0; axis < 3; ++axis) product *= static_cast<std::uint64_t>(box.hi[axis] - box.lo[axis]);
  return product;
}

std::vector<IntBox> largest_boxes(std::span<const IntBox> boxes, std::size_t most) {
  std::vector<IntBox> kept(boxes.begin(), boxes.end());
  if (kept.size() <= most) return kept;
  std::stable_sort(kept.begin(), kept.end(), [](const IntBox& a, const IntBox& b) { return volume(a) > volume(b); });
  kept.resize(most);
  return kept;
}

Json obstacles_json(const GridBoxes& obstacles) {
  if (obstacles.boxes.empty()) return nullptr;
  const std::vector<IntBox> shown = largest_boxes(obstacles.boxes, kMostBoxes);
  return {{"count", obstacles.boxes.size()}, {"shown", shown.size()},         {"origin", obstacles.origin},
          {"unit", obstacles.unit},          {"voxel", obstacles.resolution}, {"boxes", encode_boxes(shown)}};
}

std::string page(const std::string& title, const Json& report) {
  std::string html(kPageBeforeTitle);
  html += escape_html(title);
  html += kPageBeforeData;
  html += script_json(report);
  html += kPageEnd;
  return html;
}

}  // namespace

std::string plan_report_html(const PlanReportInput& input) {
  const Json report{{"kind", "plan"},
                    {"title", input.title},
                    {"version", kVersion},
                    {"obstacles", obstacles_json(input.obstacles)},
                    {"plan", input.plan}};
  return page(input.title, report);
}

}  // namespace swiftlet::tools
