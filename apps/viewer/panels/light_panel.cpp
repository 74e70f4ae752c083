#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <imgui.h>

#include "apps/viewer/panel.h"
#include "scene/lighting.h"
#include "session/direction_text.h"

namespace pleinair {
namespace {

struct Curve {
  const char* name;
  ImU32 colour;
  glm::dvec3 LightPoint::*value;
  glm::dvec3 LightPoint::*stddev;
};

// A time axis of frames, and the band of one standard deviation about each curve.
class LightPlot {
 public:
  LightPlot(const ViewModel& model, ImVec2 size)
      : points_(model.lights), origin_(ImGui::GetCursorScreenPos()), size_(size) {
    ImGui::InvisibleButton("plot", size);
    for (const LightPoint& point : points_) {
      if (point.failed) continue;
      top_ = std::max({top_, MeanOf(point.sun_rgb), MeanOf(point.sky_rgb)});
    }
    top_ = top_ > 0.0 ? 1.1 * top_ : 1.0;
    first_ = points_.empty() ? 0 : points_.front().frame;
    last_ = points_.empty() ? 1 : std::max(points_.back().frame, first_ + 1);
  }

  void DrawFrame() {
    ImDrawList& list = *ImGui::GetWindowDrawList();
    list.AddRectFilled(
        origin_, {origin_.x + size_.x, origin_.y + size_.y}, IM_COL32(20, 20, 24, 255));
    for (int line = 1; line < 4; ++line) {
      const float y = origin_.y + size_.y * static_cast<float>(line) / 4.0f;
      list.AddLine({origin_.x, y}, {origin_.x + size_.x, y}, IM_COL32(60, 60, 66, 255));
    }
    const std::string text = fmt::format("{:.3g}", top_);
    list.AddText({origin_.x + 3.0f, origin_.y + 1.0f}, IM_COL32(150, 150, 150, 255), text.c_str());
  }

  void Draw(const Curve& curve) {
    ImDrawList& list = *ImGui::GetWindowDrawList();
    const ImU32 band = (curve.colour & 0x00ffffffu) | 0x50000000u;
    const LightPoint* before = nullptr;
    // No more than a point a pixel.
    const auto columns = static_cast<std::size_t>(std::max(1.0f, size_.x));
    const std::size_t stride = std::max<std::size_t>(1, points_.size() / columns);
    for (std::size_t i = 0; i < points_.size(); i += stride) {
      const LightPoint& point = points_[i];
      if (point.failed) {
        list.AddLine(
            {X(point), origin_.y}, {X(point), origin_.y + size_.y}, IM_COL32(200, 40, 40, 120));
        before = nullptr;
        continue;
      }
      const double value = MeanOf(point.*curve.value);
      if (point.has_stddev) {
        const double stddev = MeanOf(point.*curve.stddev);
        list.AddRectFilled({X(point) - 1.0f, Y(value + stddev)},
                           {X(point) + std::max(1.0f, Step()), Y(std::max(0.0, value - stddev))},
                           band);
      }
      if (before != nullptr) {
        list.AddLine({X(*before), Y(MeanOf(before->*curve.value))},
                     {X(point), Y(value)},
                     curve.colour,
                     2.0f);
      } else {
        list.AddCircleFilled({X(point), Y(value)}, 2.0f, curve.colour);
      }
      before = &point;
    }
  }

  void DrawCursor(int frame) {
    const float x = origin_.x + size_.x * static_cast<float>(frame - first_) /
                                    static_cast<float>(last_ - first_);
    ImGui::GetWindowDrawList()->AddLine(
        {x, origin_.y}, {x, origin_.y + size_.y}, IM_COL32(255, 255, 255, 160));
  }

  // That the pointer is at, where it presses.
  std::optional<int> PressedFrame() const {
    if (!ImGui::IsItemActive()) return std::nullopt;
    const float share = std::clamp((ImGui::GetIO().MousePos.x - origin_.x) / size_.x, 0.0f, 1.0f);
    return first_ + static_cast<int>(std::lround(share * static_cast<float>(last_ - first_)));
  }

 private:
  float Step() const { return size_.x / static_cast<float>(last_ - first_); }
  float X(const LightPoint& point) const {
    return origin_.x + Step() * static_cast<float>(point.frame - first_);
  }
  float Y(double value) const {
    return origin_.y + size_.y * static_cast<float>(1.0 - std::clamp(value / top_, 0.0, 1.0));
  }

  const std::vector<LightPoint>& points_;
  ImVec2 origin_;
  ImVec2 size_;
  double top_ = 0.0;
  int first_ = 0;
  int last_ = 1;
};

void DrawNumbers(const char* name,
                 ImVec4 colour,
                 const glm::dvec3& rgb,
                 const LightPoint* point,
                 const glm::dvec3 LightPoint::*stddev) {
  std::string text = fmt::format("{} {:8.4g} {:8.4g} {:8.4g}", name, rgb.x, rgb.y, rgb.z);
  if (point != nullptr && point->has_stddev && MeanOf(rgb) > 0.0) {
    text += fmt::format("  +/- {:.1f} %", 100.0 * MeanOf(point->*stddev) / MeanOf(rgb));
  }
  ImGui::TextColored(colour, "%s", text.c_str());
}

}  // namespace

void DrawLightPanel(ViewModel& model) {
  constexpr Curve kSun{
      "sun", IM_COL32(255, 205, 60, 255), &LightPoint::sun_rgb, &LightPoint::sun_stddev_rgb};
  constexpr Curve kSky{
      "sky", IM_COL32(90, 160, 255, 255), &LightPoint::sky_rgb, &LightPoint::sky_stddev_rgb};
  const float height = std::max(
      60.0f, ImGui::GetContentRegionAvail().y - 5.0f * ImGui::GetTextLineHeightWithSpacing());
  LightPlot plot(model, {ImGui::GetContentRegionAvail().x, height});
  plot.DrawFrame();
  plot.Draw(kSky);
  plot.Draw(kSun);
  if (model.frame) plot.DrawCursor(model.frame->Index());
  if (const auto pressed = plot.PressedFrame();
      pressed && model.frame && *pressed != model.frame->Index()) {
    model.Seek(*pressed);
  }
  const FrameResult* result = model.Result();
  if (result == nullptr) return;
  const LightPoint* now = nullptr;
  for (const LightPoint& point : model.lights) {
    if (point.frame == model.frame->Index()) now = &point;
  }
  const Lighting& light = result->estimate.lighting;
  DrawNumbers(
      "sun", {1.0f, 0.8f, 0.24f, 1.0f}, light.sun.irradiance_rgb, now, &LightPoint::sun_stddev_rgb);
  DrawNumbers("sky",
              {0.45f, 0.68f, 1.0f, 1.0f},
              light.SkyIrradianceRgb(),
              now,
              &LightPoint::sky_stddev_rgb);
  const char* units = result->estimate.units == LightUnits::kAbsolute ? "the survey's units"
                      : result->estimate.units == LightUnits::kRelative
                          ? "relative: one factor for all frames"
                          : "relative, frame by frame";
  ImGui::PushTextWrapPos();
  ImGui::TextDisabled("irradiance in RGB, %s", units);
  const glm::dvec3& sun = light.sun.direction_enu;
  ImGui::TextDisabled("sun at %s%s",
                      sun.z < -0.999 ? "no place" : AzimuthAndElevation(sun).c_str(),
                      result->estimate.sun_observable ? "" : ", not observable in this frame");
  ImGui::PopTextWrapPos();
}

}  // namespace pleinair
