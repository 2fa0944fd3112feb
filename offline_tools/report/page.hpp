#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "report/grid_boxes.hpp"

namespace swiftlet::tools {

/// What the pages of this folder are made of.

/// The viewer's page with a title (plain text) and the data that its script reads: kind, title and more.
std::string page(const std::string& title, const nlohmann::ordered_json& report);

/// Base64 of 16-bit integers, little-endian.
std::string encode_integers(std::span<const std::uint16_t> integers);

/// Base64 of the six corners of every box as 16-bit little-endian integers, 16 characters a box.
std::string encode_boxes(std::span<const IntBox> boxes);

/// Values as 16-bit integers, {low, step, values}: value i is low + step * integer i, to half a step; 65535 stands for
/// one that is not finite.
nlohmann::ordered_json channel_json(std::span<const double> values);

/// Volume [unit^3].
std::uint64_t volume(const IntBox& box);

/// Which of `count` items a page shows: all, in order, or else the `most` of largest size, largest first.
std::vector<std::size_t> largest_items(std::size_t count, std::size_t most,
                                       const std::function<std::uint64_t(std::size_t)>& size_of);

/// At most `most` obstacles, the largest, and how many there are; null without any.
nlohmann::ordered_json obstacles_json(const GridBoxes& obstacles, std::size_t most);

}  // namespace swiftlet::tools
