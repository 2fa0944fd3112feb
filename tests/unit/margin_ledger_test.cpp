#include "swiftlet/margin_ledger.hpp"

#include <limits>

#include "swiftlet_test.hpp"

namespace swiftlet {
namespace {

constexpr MarginLedger kLedger{Real(0.2), Real(0.05), Real(0.15), Real(1e-6)};

TEST(MarginLedger, AddsItsSharesUp) {
  const MarginReport report = check_margins(kLedger, Real(0.5));
  EXPECT_TRUE(report.verdict == MarginVerdict::kCovered);
  EXPECT_NEAR(report.required, 0.400001, 1e-6);
  EXPECT_EQ(report.missing, 0);
}

TEST(MarginLedger, RefusesAMapThatIsTooTightAndSaysByHowMuch) {
  MarginLedger ledger = kLedger;
  ledger.tracking_tube = tube_of({}, SetpointForm::kPosition);
  const MarginReport report = check_margins(ledger, Real(0.5));
  EXPECT_TRUE(report.verdict == MarginVerdict::kMapTooTight);
  EXPECT_NEAR(report.missing, 0.250001, 1e-6);
}

TEST(MarginLedger, WhatIsLeftIsHowFarTheHeadingMayLead) {
  MarginLedger ledger = kLedger;
  EXPECT_EQ(check_margins(ledger, Real(0.5)).reach, kUnlimited);  // not budgeted
  ledger.heading_accuracy = Real(0.01);
  const MarginReport report = check_margins(ledger, Real(0.5));
  EXPECT_TRUE(report.verdict == MarginVerdict::kCovered);
  EXPECT_NEAR(report.required, 0.400001, 1e-6);
  EXPECT_NEAR(report.reach, 9.9999, 1e-4);
  EXPECT_EQ(check_margins(ledger, report.required).reach, 0);
  EXPECT_TRUE(check_margins(ledger, report.required).verdict == MarginVerdict::kCovered);
  EXPECT_EQ(check_margins(ledger, Real(0.3)).reach, 0);
  EXPECT_TRUE(check_margins(ledger, Real(0.3)).verdict == MarginVerdict::kMapTooTight);
}

TEST(MarginLedger, TheFormInUseDecidesTheTube) {
  const TrackingTubes tubes{1, 2, 3};
  EXPECT_EQ(tube_of(tubes, SetpointForm::kPosition), 1);
  EXPECT_EQ(tube_of(tubes, SetpointForm::kAttitude), 2);
  EXPECT_EQ(tube_of(tubes, SetpointForm::kRates), 3);
}

TEST(MarginLedger, RefusesNegativeSharesAndThoseThatAreNone) {
  const Real nan = std::numeric_limits<Real>::quiet_NaN();
  for (const Real bad : {nan, Real(-0.1), std::numeric_limits<Real>::infinity()}) {
    for (int field = 0; field < 6; ++field) {
      MarginLedger ledger = kLedger;
      if (field == 0) ledger.vehicle_radius = bad;
      if (field == 1) ledger.map_error = bad;
      if (field == 2) ledger.tracking_tube = bad;
      if (field == 3) ledger.numeric_margin = bad;
      if (field == 4) ledger.heading_accuracy = bad;
      EXPECT_TRUE(check_margins(ledger, field == 5 ? bad : Real(1)).verdict == MarginVerdict::kBadNumber);
    }
  }
}

TEST(MarginLedger, DescribesEveryVerdict) {
  for (const MarginVerdict verdict :
       {MarginVerdict::kCovered, MarginVerdict::kMapTooTight, MarginVerdict::kBadNumber}) {
    EXPECT_NE(describe(verdict)[0], 'u');
  }
}

}  // namespace
}  // namespace swiftlet
