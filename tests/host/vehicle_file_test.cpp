#include "cli/vehicle_file.hpp"

#include <gtest/gtest.h>

#include <cstdio>
#include <fstream>

#include "cli/failure.hpp"

namespace swiftlet::tools {
namespace {

/// What `load_vehicle` makes of the text: the file, or the line that refuses it.
struct Answer {
  VehicleFile file{};
  std::string refusal;
};

Answer load(const std::string& text) {
  const std::string path = testing::TempDir() + "vehicle_file_test.json";
  std::ofstream(path) << text;
  Answer answer;
  try {
    answer.file = load_vehicle(path);
  } catch (const Failure& failure) {
    EXPECT_EQ(failure.status, ExitStatus::kBadFile);
    answer.refusal = failure.line;
  }
  std::remove(path.c_str());
  return answer;
}

std::string vehicle(const std::string& simulation) {
  return R"({"format": "swiftlet-vehicle/1", "mass_kg": 2, "thrust_min_n": 1, "thrust_max_n": 40,
             "rate_max_rad_s": 3)" +
         simulation + "}";
}

TEST(VehicleFile, GivesTheVehicleWithUsualValuesForWhatIsOptional) {
  const Answer answer = load(vehicle(""));
  EXPECT_EQ(answer.refusal, "");
  EXPECT_EQ(answer.file.model.mass, 2);
  EXPECT_EQ(answer.file.model.thrust_min, 1);
  EXPECT_EQ(answer.file.model.thrust_max, 40);
  EXPECT_EQ(answer.file.model.rate_max, 3);
  EXPECT_EQ(answer.file.model.motor_lag, VehicleModel{}.motor_lag);
  EXPECT_NEAR(answer.file.hover_thrust, 2 * kGravity / 40, 1e-12);
}

TEST(VehicleFile, TakesTheSimulationsValues) {
  const Answer answer = load(vehicle(
      R"(, "simulation": {"inertia_kg_m2": [0.1, 0.2, 0.3], "motor_lag_s": 0.03, "arm_m": 0.3, "drag_n_per_mps": 0,
          "torque_per_thrust_m": 0.01, "angular_drag_nm_per_rad_s": 0, "hover_thrust": 0.4})"));
  EXPECT_EQ(answer.refusal, "");
  EXPECT_EQ(answer.file.model.inertia, Vector3(0.1, 0.2, 0.3));
  EXPECT_EQ(answer.file.model.motor_lag, 0.03);
  EXPECT_EQ(answer.file.model.arm, 0.3);
  EXPECT_EQ(answer.file.model.drag, 0);
  EXPECT_EQ(answer.file.hover_thrust, 0.4);
}

TEST(VehicleFile, NamesWhatItRefuses) {
  const auto refuses = [](const std::string& text, const std::string& words) {
    const std::string refusal = load(text).refusal;
    EXPECT_NE(refusal.find(words), std::string::npos) << refusal;
    EXPECT_EQ(refusal.find('\n'), std::string::npos);
  };
  refuses(vehicle(R"(, "colour": 1)"), "'colour' is not a known key");
  refuses(vehicle(R"(, "simulation": {"wings": 2})"), "'simulation.wings' is not a known key");
  refuses(vehicle(R"(, "simulation": 3)"), "'simulation' is not a JSON object");
  refuses(vehicle(R"(, "simulation": {"motor_lag_s": 0})"), "'simulation.motor_lag_s'");
  refuses(vehicle(R"(, "simulation": {"inertia_kg_m2": [1, 2]})"), "has 2 numbers, not 3");
  refuses(vehicle(R"(, "simulation": {"inertia_kg_m2": [1, 0, 1]})"), "not greater than 0");
  refuses(vehicle(R"(, "simulation": {"drag_n_per_mps": "much"})"), "is not a number");
  refuses(R"({"format": "swiftlet-vehicle/1"})", "'mass_kg' is missing");
  refuses(R"({"format": "swiftlet-vehicle/2"})", "'format'");
  refuses(R"({"format": "swiftlet-vehicle/1", "mass_kg": 2, "thrust_min_n": 0, "thrust_max_n": 19,
              "rate_max_rad_s": 3})",
          "cannot hover");
  refuses("[]", "not a JSON object");
  refuses("", "empty");
}

}  // namespace
}  // namespace swiftlet::tools
