#include "apps/site_day_picture.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <opencv2/imgproc.hpp>

#include "sunmodel/angles.h"
#include "sunmodel/time_text.h"

namespace pleinair {
namespace {

// RGB, as Rgb8Image.
const cv::Scalar kPaper{255, 255, 255};
const cv::Scalar kInk{30, 30, 30};
const cv::Scalar kFaint{210, 210, 210};
const cv::Scalar kLit{214, 128, 0};
const cv::Scalar kShaded{32, 96, 192};
const cv::Scalar kGood{0, 128, 64};
const cv::Scalar kBad{180, 40, 30};

constexpr int kPanelWidth = 280;
constexpr int kGap = 14;
constexpr int kLine = 19;
constexpr int kTextLines = 4;
constexpr int kMostColumns = 4;
constexpr int kChartHeight = 150;
constexpr int kMostLabels = 16;
constexpr double kTextSize = 0.44;

void Text(cv::Mat& picture, const std::string& text, cv::Point at, const cv::Scalar& colour) {
  cv::putText(picture, text, at, cv::FONT_HERSHEY_SIMPLEX, kTextSize, colour, 1, cv::LINE_AA);
}

std::string HourText(UtcTime time) { return FormatUtcTime(time).substr(11, 5) + "Z"; }

std::string Percent(const std::optional<double>& share) {
  if (!share) return "-";
  return *share > 9.99 ? ">999 %" : fmt::format("{:.0f} %", 100.0 * *share);
}

void DrawPanel(cv::Mat& picture, const SiteHour& hour, cv::Point at, int height) {
  const Rgb8Image& seen = hour.light.picture;
  const cv::Rect frame(at.x, at.y, kPanelWidth, height);
  const cv::Mat full(seen.height,
                     seen.width,
                     CV_8UC3,
                     const_cast<glm::u8vec3*>(seen.pixels.data()));  // Read only.
  cv::Mat part = picture(frame);
  cv::resize(full, part, frame.size(), 0.0, 0.0, cv::INTER_AREA);
  const bool known = SunWillBeKnown(hour);
  cv::rectangle(picture, frame, known ? kGood : kBad, 2);
  const LightForecast& light = hour.light;
  cv::Point line(at.x + 2, at.y + height + kLine);
  const auto next = [&](const std::string& text, const cv::Scalar& colour) {
    Text(picture, text, line, colour);
    line.y += kLine;
  };
  const double elevation_deg =
      DegFromRad(std::asin(std::clamp(light.sun.direction_enu.z, -1.0, 1.0)));
  next(fmt::format("{}  sun at {:.0f} deg{}",
                   HourText(light.time),
                   elevation_deg,
                   known ? "" : "  not known"),
       known ? kGood : kBad);
  next(fmt::format(
           "lit {:.0f} %  shaded {:.0f} %", 100.0 * light.lit_share, 100.0 * light.shaded_share),
       kInk);
  next(fmt::format("sigma sun {}  sky {}",
                   Percent(light.sun_relative_stddev),
                   Percent(light.sky_relative_stddev)),
       kInk);
  if (hour.sun_on_objects) next("sun on the object " + Percent(hour.sun_on_objects), kInk);
}

// Shares over the day as columns: sun on diffuse surfaces, and shade.
void DrawShares(cv::Mat& picture, const SiteDay& day, const cv::Rect& box) {
  Text(picture,
       "diffuse surfaces in view: lit (orange), shaded (blue); dots: sun on the object",
       {box.x, box.y - 6},
       kInk);
  cv::rectangle(picture, box, kFaint, 1);
  const auto hours = static_cast<int>(day.hours.size());
  for (int i = 0; i < hours; ++i) {
    const SiteHour& hour = day.hours[static_cast<std::size_t>(i)];
    const int left = box.x + box.width * i / hours;
    const int width = std::max(2, box.width / hours - 3);
    const auto column = [&](double share, int x, int w, const cv::Scalar& colour) {
      const int high = static_cast<int>(std::lround(share * (box.height - 2)));
      cv::rectangle(
          picture, cv::Rect(x, box.y + box.height - 1 - high, w, high), colour, cv::FILLED);
    };
    column(hour.light.lit_share, left + 1, width / 2, kLit);
    column(hour.light.shaded_share, left + 1 + width / 2, width - width / 2, kShaded);
    if (hour.sun_on_objects) {
      const int y = box.y + box.height - 1 -
                    static_cast<int>(std::lround(*hour.sun_on_objects * (box.height - 2)));
      cv::circle(picture, {left + 1 + width / 2, y}, 4, kInk, cv::FILLED, cv::LINE_AA);
    }
    if (i % ((hours + kMostLabels - 1) / kMostLabels) == 0) {
      Text(picture, HourText(hour.light.time).substr(0, 5), {left, box.y + box.height + 16}, kInk);
    }
  }
}

// Relative deviations on a logarithmic axis from 1 % to 100 %.
void DrawDeviations(cv::Mat& picture, const SiteDay& day, const cv::Rect& box) {
  Text(picture,
       "sigma of the sun (orange) and of the sky (blue), relative to the clear sky's light",
       {box.x, box.y - 6},
       kInk);
  cv::rectangle(picture, box, kFaint, 1);
  const auto y_of = [&](double value) {
    const double level = std::clamp(std::log10(value / 0.01) / 2.0, 0.0, 1.0);
    return box.y + box.height - static_cast<int>(std::lround(level * box.height));
  };
  for (const double mark : {0.01, 0.03, 0.1, 0.3, 1.0}) {
    cv::line(picture, {box.x, y_of(mark)}, {box.x + box.width, y_of(mark)}, kFaint, 1);
    Text(picture,
         fmt::format("{:.0f} %", 100.0 * mark),
         {box.x + box.width + 4, y_of(mark) + 5},
         kInk);
  }
  const auto hours = static_cast<int>(day.hours.size());
  const auto draw = [&](std::optional<double> LightForecast::*which, const cv::Scalar& colour) {
    std::optional<cv::Point> last;
    for (int i = 0; i < hours; ++i) {
      const auto value = day.hours[static_cast<std::size_t>(i)].light.*which;
      if (!value || !(*value > 0.0)) {
        last.reset();
        continue;
      }
      const cv::Point at(box.x + box.width * (2 * i + 1) / (2 * hours), y_of(*value));
      if (last) cv::line(picture, *last, at, colour, 2, cv::LINE_AA);
      cv::circle(picture, at, 3, colour, cv::FILLED, cv::LINE_AA);
      last = at;
    }
  };
  draw(&LightForecast::sun_relative_stddev, kLit);
  draw(&LightForecast::sky_relative_stddev, kShaded);
}

}  // namespace

Rgb8Image DrawSiteDay(const std::string& title, const SiteDay& day) {
  if (day.hours.empty()) throw std::invalid_argument("day: expected an hour with the sun up");
  int panel_height = kPanelWidth * 3 / 4;
  std::vector<const SiteHour*> shown;
  for (const SiteHour& hour : day.hours) {
    const Rgb8Image& seen = hour.light.picture;
    if (seen.pixels.empty()) continue;
    panel_height = std::max(1, kPanelWidth * seen.height / seen.width);
    shown.push_back(&hour);
  }
  const auto panels = static_cast<int>(shown.size());
  const int columns = std::clamp(panels, 1, kMostColumns);
  const int rows = (panels + columns - 1) / columns;
  const int cell_height = panel_height + kTextLines * kLine + kGap;
  const int header = 2 * kLine + kGap;
  constexpr int kRightMarks = 60;
  const int width = std::max(2 * kPanelWidth, columns * (kPanelWidth + kGap)) + kGap + kRightMarks;
  const int charts = 2 * (kChartHeight + 3 * kLine) + kGap;
  cv::Mat picture(header + rows * cell_height + charts, width, CV_8UC3, kPaper);

  Text(picture, title, {kGap, kLine + 4}, kInk);
  Text(picture,
       "under a clear sky, as the camera would see the mesh; green: sun and sky can be separated",
       {kGap, 2 * kLine + 4},
       kInk);
  for (int i = 0; i < panels; ++i) {
    DrawPanel(picture,
              *shown[static_cast<std::size_t>(i)],
              {kGap + i % columns * (kPanelWidth + kGap), header + i / columns * cell_height},
              panel_height);
  }
  const int chart_width = width - 2 * kGap - kRightMarks;
  int y = header + rows * cell_height + kLine;
  DrawShares(picture, day, {kGap, y, chart_width, kChartHeight});
  y += kChartHeight + 3 * kLine;
  DrawDeviations(picture, day, {kGap, y, chart_width, kChartHeight});

  Rgb8Image result(picture.cols, picture.rows);
  for (int row = 0; row < picture.rows; ++row) {
    const auto* pixels = picture.ptr<glm::u8vec3>(row);
    std::copy(pixels, pixels + picture.cols, &result.At(0, row));
  }
  return result;
}

}  // namespace pleinair
