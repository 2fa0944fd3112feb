#pragma once
#include <CLI/CLI.hpp>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "swiftlet/types.hpp"

namespace swiftlet::tools {

/// Finite numbers from `lo` to `hi`.
struct NumberRange {
  double lo = std::numeric_limits<double>::lowest();
  double hi = std::numeric_limits<double>::max();
};

/// `--name N`: a finite number of the range; anything else is a usage error that says so.
CLI::Option* add_number(CLI::App& app, const std::string& name, double& target, const NumberRange& range,
                        const std::string& description);

/// `--name N`: a whole number from `lo` to `hi`.
CLI::Option* add_count(CLI::App& app, const std::string& name, std::uint64_t& target, std::uint64_t lo,
                       std::uint64_t hi, const std::string& description);

/// `--name X,Y,Z`: three finite numbers.
CLI::Option* add_vector(CLI::App& app, const std::string& name, Vector3& target, const std::string& description);

/// `--name WORD`: one of the choices.
CLI::Option* add_choice(CLI::App& app, const std::string& name, std::string& target,
                        const std::vector<std::string>& choices, const std::string& description);

}  // namespace swiftlet::tools
