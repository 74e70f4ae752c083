// A report of a run without end: bounded in memory, exact in its totals.
#include "apps/run_report.h"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scene/image_io.h"
#include "tests/scene/temporary_folder.h"

namespace pleinair::run_report_test {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

constexpr int kFrames = 100'000;  // 55 minutes at 30 a second.
const UtcTime kStart = std::chrono::sys_days{std::chrono::year{2026} / 6 / 21} + 10h;

// Every hundredth one has failed; each thousandth has left an effect out.
ReportFrame FrameOf(int index) {
  ReportFrame frame;
  frame.index = index;
  frame.time = kStart + index * 33'333'333ns;
  if (index % 100 == 7) {
    frame.error = "no picture";
    return frame;
  }
  frame.lighting.sun.irradiance_rgb = glm::dvec3(index);
  frame.timing_ms.render = 10.0 + index % 10;
  frame.latency_ms = 1.0 + index % 1000;
  frame.plan.all_expected_ms = 3.0;
  frame.plan.expected_ms = index % 1000 == 0 ? 1.0 : 3.0;
  frame.plan.fits_budget = index % 1000 != 0;
  PlannedEffect& effect = frame.plan.effects[0];
  effect.effect = Effect::kSunShading;
  effect.fate = index % 1000 == 0 ? EffectFate::kLeftOut : EffectFate::kRun;
  effect.bound_code_values = index == 5000 ? 12.5 : 2.0;
  return frame;
}

RunReport LongReport(const TemporaryFolder& folder) {
  RunReport report(folder.Path());
  for (int i = 0; i < kFrames; ++i) report.Add(FrameOf(i));
  return report;
}

TEST(RunReport, KeepsAFewFramesEvenlyOverAnyNumber) {
  const TemporaryFolder folder;
  RunReport report(folder.Path());
  std::size_t most_frames = 0;
  std::size_t most_lights = 0;
  for (int i = 0; i < kFrames; ++i) {
    const bool shows = report.ShowsNext();
    const std::size_t before = report.frames.size();
    report.Add(FrameOf(i));
    // It is shown, and may halve the others.
    EXPECT_EQ(report.frames.size() != before, shows) << i;
    most_frames = std::max(most_frames, report.frames.size());
    most_lights = std::max(most_lights, report.light.size());
  }
  EXPECT_LE(most_frames, 400u);
  EXPECT_LE(most_lights, 4000u);
  EXPECT_GE(report.frames.size(), 100u);
  EXPECT_GE(report.light.size(), 1000u);
  // From the first one on at the same distance, to within that of the end.
  const int stride = report.frames[1].index;
  for (std::size_t i = 0; i < report.frames.size(); ++i) {
    ASSERT_EQ(report.frames[i].index, static_cast<int>(i) * stride);
  }
  EXPECT_GT(report.frames.back().index + stride, kFrames - 1);
  const auto light_stride = report.light[1].time - kStart;
  for (std::size_t i = 0; i < report.light.size(); ++i) {
    ASSERT_EQ(report.light[i].time, kStart + static_cast<int>(i) * light_stride);
  }
}

// Each picture's grey level is the frame's number.
TEST(RunReport, ShowsEachFrameItsOwnPictures) {
  const TemporaryFolder folder;
  RunReport report(folder.Path());
  const auto grey = [](int index, int offset) { return (index / 4 + offset) % 256; };
  for (int i = 0; i < 1000; ++i) {
    ReportFrame frame;
    frame.index = i;
    if (report.ShowsNext()) {
      for (const auto& [picture, offset] :
           {std::pair{&frame.input, 0}, std::pair{&frame.composite, 128}}) {
        const auto level = static_cast<std::uint8_t>(grey(i, offset));
        *picture = report.AddPicture(Rgb8Image(16, 16, glm::u8vec3(level)));
      }
    }
    report.Add(std::move(frame));
  }
  ASSERT_LT(report.frames.size(), 400u);
  const auto level_of = [&](const std::optional<SetAside::Place>& picture) {
    return int{
        ReadDisplayImage(folder.Write("picture.jpg", report.Jpeg(picture.value()))).pixels[0].g};
  };
  for (const ReportFrame& frame : report.frames) {
    EXPECT_NEAR(level_of(frame.input), grey(frame.index, 0), 1) << frame.index;
    EXPECT_NEAR(level_of(frame.composite), grey(frame.index, 128), 1) << frame.index;
  }
}

TEST(RunReport, SaysWhichFramesAreDrawnWithoutASun) {
  const TemporaryFolder folder;
  RunReport report(folder.Path());
  report.Add(FrameOf(0));
  ReportFrame unsure = FrameOf(1);
  unsure.is_drawn_without_sun = true;
  report.Add(std::move(unsure));
  WriteRunReport(folder.Path() / "report.html", report);
  const std::string page = ContentOf(folder.Path() / "report.html");
  const std::string words = "drawn without a sun";
  EXPECT_NE(page.find(words), std::string::npos);
  EXPECT_EQ(page.find(words), page.rfind(words)) << "of one of the two frames";
}

TEST(RunReport, ItsTotalsAreOfAllFrames) {
  const TemporaryFolder folder;
  const ReportTotals totals = LongReport(folder).totals;
  EXPECT_EQ(totals.failed, kFrames / 100);
  EXPECT_EQ(totals.done, kFrames - kFrames / 100);
  EXPECT_EQ(totals.first_failure, "frame 7: no picture");
  EXPECT_EQ(totals.latency.Count(), totals.done);
  EXPECT_EQ(totals.latency.LargestMs(), 1000.0);
  // Latencies are 1 to 1000 ms, each as often; those that failed are spread evenly.
  EXPECT_NEAR(totals.latency.QuantileMs(0.5), 501.0, 0.005 * 501.0 + 1.0);
  EXPECT_NEAR(totals.latency.QuantileMs(0.99), 991.0, 0.005 * 991.0 + 1.0);
  EXPECT_EQ(totals.beyond_budget, kFrames / 1000);
  EXPECT_DOUBLE_EQ(totals.saved_ms, 2.0 * kFrames / 1000);
  EXPECT_DOUBLE_EQ(totals.all_ms, 3.0 * static_cast<double>(totals.done));
  const ReportTotals::OfEffect& effect = totals.effects.at(Effect::kSunShading);
  EXPECT_EQ(effect.frames[static_cast<std::size_t>(EffectFate::kLeftOut)], kFrames / 1000);
  EXPECT_EQ(effect.frames[static_cast<std::size_t>(EffectFate::kRun)],
            totals.done - kFrames / 1000);
  EXPECT_EQ(effect.largest_left_out_code_values, 12.5);
}

TEST(RunReport, KeepsTheFirstEventsAndCountsTheOthers) {
  const TemporaryFolder folder;
  RunReport report(folder.Path());
  for (int i = 0; i < 5000; ++i) {
    report.AddEvent({kStart + i * 1s, EventKind::kFrameDropped, std::to_string(i)});
  }
  EXPECT_EQ(report.events.size() + static_cast<std::size_t>(report.events_left_out), 5000u);
  EXPECT_LE(report.events.size(), 1000u);
  for (std::size_t i = 0; i < report.events.size(); ++i) {
    ASSERT_EQ(report.events[i].text, std::to_string(i));
  }
}

TEST(RunReport, APageOfALongRunIsSmallAndComplete) {
  const TemporaryFolder folder;
  RunReport report = LongReport(folder);
  report.title = "a <long> run";
  report.notes = {"nothing & nobody"};
  report.AddEvent({kStart, EventKind::kUnplugged, "/dev/video0: \"gone\" <b>"});
  WriteRunReport(folder / "report.html", report);
  const std::string page = ContentOf(folder / "report.html");
  EXPECT_LT(page.size(), 2'000'000u);
  EXPECT_THAT(page, testing::EndsWith("</html>\n"));
  EXPECT_THAT(page, HasSubstr("a &lt;long&gt; run"));
  EXPECT_THAT(page, HasSubstr("nothing &amp; nobody"));
  EXPECT_THAT(page, HasSubstr("<td>unplugged</td>"));
  EXPECT_THAT(page, testing::Not(HasSubstr("<b>\"")));
  EXPECT_THAT(page, HasSubstr("&lt;b&gt;"));
}

TEST(RunReport, AnEmptyOneIsAPage) {
  const TemporaryFolder folder;
  WriteRunReport(folder / "report.html", RunReport(folder.Path()));
  EXPECT_THAT(ContentOf(folder / "report.html"), testing::EndsWith("</html>\n"));
}

}  // namespace
}  // namespace pleinair::run_report_test
