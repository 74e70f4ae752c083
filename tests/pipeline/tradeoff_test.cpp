#include "pipeline/tradeoff.h"

#include <gtest/gtest.h>

namespace pleinair::tradeoff_test {
namespace {

TEST(Tradeoff, SpreadIsMedianSmallestAndLargest) {
  const std::vector<double> values{3.0, 1.0, 2.0, 10.0};
  const Spread spread = *SpreadOf(values);
  EXPECT_DOUBLE_EQ(spread.median, 2.5);
  EXPECT_EQ(spread.smallest, 1.0);
  EXPECT_EQ(spread.largest, 10.0);
  EXPECT_FALSE(SpreadOf({}));
}

// Quick and poor, slow and good, and between them one that is worth its time and one that is not.
TEST(Tradeoff, TheFrontIsWhatNoOtherBeats) {
  const std::vector<TradeoffPoint> points{
      {{0.10}, {1.0}}, {{0.05}, {2.0}}, {{0.06}, {3.0}}, {{0.01}, {9.0}}};
  const std::vector<FrontPlace> places = PlacesOnFront(points);
  ASSERT_EQ(places.size(), 4u);
  EXPECT_TRUE(places[0].on_front);
  EXPECT_TRUE(places[1].on_front);
  EXPECT_FALSE(places[2].on_front);
  EXPECT_EQ(places[2].beaten_by, 1u);
  EXPECT_TRUE(places[3].on_front);
  EXPECT_FALSE(places[3].beaten_by);
}

TEST(Tradeoff, EqualPointsAreBothOnTheFront) {
  const std::vector<TradeoffPoint> points{{{0.1}, {1.0}}, {{0.1}, {1.0}}, {{0.1}, {1.5}}};
  const std::vector<FrontPlace> places = PlacesOnFront(points);
  EXPECT_TRUE(places[0].on_front);
  EXPECT_TRUE(places[1].on_front);
  EXPECT_FALSE(places[2].on_front) << "as good, but slower";
}

// Medians decide; the comparison seed by seed states how certain that is.
TEST(Tradeoff, CountsTheSeedsWithWhichAPointIsBeaten) {
  const std::vector<TradeoffPoint> points{{{0.3, 0.1, 0.3}, {2.0, 2.0, 9.0}},
                                          {{0.2, 0.2, 0.2}, {1.0, 9.0, 1.0}}};
  const std::vector<FrontPlace> places = PlacesOnFront(points);
  EXPECT_FALSE(places[0].on_front);
  EXPECT_EQ(places[0].beaten_by, 1u);
  EXPECT_EQ(places[0].seeds_beaten, 2);
  EXPECT_EQ(places[0].seeds, 3);
}

TEST(Tradeoff, APointWithoutValuesIsPassedOver) {
  const std::vector<TradeoffPoint> points{{{}, {}}, {{0.2}, {1.0}}};
  const std::vector<FrontPlace> places = PlacesOnFront(points);
  EXPECT_FALSE(places[0].on_front);
  EXPECT_FALSE(places[0].beaten_by);
  EXPECT_TRUE(places[1].on_front);
  EXPECT_TRUE(PlacesOnFront({}).empty());
}

}  // namespace
}  // namespace pleinair::tradeoff_test
