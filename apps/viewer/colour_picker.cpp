#include "apps/viewer/colour_picker.h"

#include <algorithm>
#include <exception>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>
#include <glm/geometric.hpp>

#include "apps/picture_files.h"
#include "apps/site_response.h"
#include "calib/shown_picture.h"
#include "objects/surface_point.h"
#include "scene/lat_long.h"

namespace pleinair {
namespace {

// Of places in the survey map, beside those in the camera's picture: its pixels are larger.
constexpr double kSurveyRadiusShare = 0.5;

}  // namespace

ColourPicker::ColourPicker(std::shared_ptr<const ViewedSite> site) : site_(std::move(site)) {
  ReadResponse();
  OpenSurvey();
}

void ColourPicker::OpenSurvey() {
  const Sequence& sequence = site_->loaded->sequence;
  if (!sequence.environment) return;
  try {
    OpenOther(sequence.folder / sequence.environment->image);
    other_is_survey_ = true;
  } catch (const std::exception& error) {
    why_no_survey_ = error.what();
  }
}

void ColourPicker::SetSite(std::shared_ptr<const ViewedSite> site) {
  site_ = std::move(site);
  // With albedos from elsewhere, the map is left out; its picture stays.
  other_is_survey_ = other_is_survey_ && site_->loaded->sequence.environment;
  if (!other_shown_) OpenSurvey();
  ReadResponse();
}

void ColourPicker::ReadResponse() {
  try {
    response_ = ResponseFrom(ResponseNameIn(site_->loaded->sequence.file));
  } catch (const std::exception& error) {
    response_ = tl::unexpected(std::string(error.what()));
  }
  Measure();
}

void ColourPicker::Measure() {
  light_ = codes_.Empty() || !response_ ? RgbImage() : RadianceFromCodes(codes_, *response_, 1.0);
  Fit();
}

std::string ColourPicker::WhyUnmeasured() const {
  if (camera_ && codes_.Empty()) {
    return "the camera's pictures are linear: expected 8-bit ones, whose response takes the "
           "factors";
  }
  return response_ ? std::string() : response_.error();
}

void ColourPicker::Look(const ViewedFrame& frame) {
  if (frame.number == looked_at_ || !frame.step.frame) return;
  looked_at_ = frame.number;
  const Frame& seen = *frame.step.frame;
  camera_ = seen.camera;
  codes_ = seen.codes.value_or(Rgb8Image());
  Measure();
}

void ColourPicker::OpenOther(const std::filesystem::path& file) {
  RgbImage light = ReadLinear(file, "srgb8");
  other_shown_ = std::make_shared<const Rgb8Image>(Shown(light));
  other_light_ = std::move(light);
  other_is_survey_ = false;
  Fit();
}

void ColourPicker::SetWay(ColourWay way) {
  if (way == now_.way) return;
  undo_.Remember(now_);
  now_.way = way;
  held_.reset();
  Fit();
}

std::optional<ColourPicker::Residual> ColourPicker::ResidualOf(std::size_t index) const {
  if (!tie_ || !*tie_ || now_.way != ColourWay::kSurfaces || !now_.surfaces.at(index).other) {
    return std::nullopt;
  }
  const auto pair = static_cast<std::size_t>(
      std::count_if(now_.surfaces.begin(),
                    now_.surfaces.begin() + static_cast<std::ptrdiff_t>(index),
                    [](const PickedSurface& surface) { return surface.other.has_value(); }));
  return Residual{(*tie_)->residual_relative[pair], (*tie_)->counts[pair]};
}

std::string ColourPicker::Describe() const {
  if (std::string why = WhyUnmeasured(); !why.empty()) return why;
  if (tie_ && !*tie_) return tie_->error();
  if (!other_shown_) {
    return why_no_survey_.empty() ? "no other picture: the site has no survey map; open a picture"
                                  : why_no_survey_ + "; another picture can be opened";
  }
  if (tie_) {
    const ColourTie& tie = **tie_;
    return fmt::format("red {:.4g}, green {:.4g}, blue {:.4g}; {:.2f} % rms over {} of {} pairs",
                       tie.to_from_rgb[0][0],
                       tie.to_from_rgb[1][1],
                       tie.to_from_rgb[2][2],
                       100.0 * tie.rms_relative,
                       std::count(tie.counts.begin(), tie.counts.end(), true),
                       tie.counts.size());
  }
  if (now_.way == ColourWay::kSurfaces) return "press surfaces that both pictures show";
  for (const ChartMarks& chart : now_.charts) {
    if (std::string missing = chart.Missing(); !missing.empty()) return missing;
  }
  return {};
}

std::optional<std::size_t> ColourPicker::SurfaceNear(PictureSide side,
                                                     const glm::dvec2& pixel,
                                                     double reach_px) const {
  std::optional<std::size_t> nearest;
  for (std::size_t i = 0; i < now_.surfaces.size(); ++i) {
    const PickedSurface& surface = now_.surfaces[i];
    if (side == PictureSide::kOther && !surface.other) continue;
    const PickedDisc& disc = side == PictureSide::kCamera ? surface.camera : *surface.other;
    const double distance_px = glm::distance(disc.at_px, pixel);
    if (!(distance_px < reach_px)) continue;
    reach_px = distance_px;
    nearest = i;
  }
  return nearest;
}

std::optional<glm::dvec2> ColourPicker::PlaceInSurvey(const glm::dvec2& pixel) const {
  const SequenceSite& site = site_->loaded->site;
  const auto surface = SurfaceAt(site_->caster, site.model.mesh, *camera_, pixel);
  if (!surface) return std::nullopt;
  const glm::dvec3 from_m = site_->loaded->sequence.environment->position_m;
  const glm::dvec3 way = surface->position_m - from_m;
  const double distance_m = glm::length(way);
  // What stands in front by more than the surface's own roundness hides it.
  constexpr double kShare = 0.995;
  if (!(distance_m > 0.0) || site_->caster.Occluded(glm::vec3(from_m),
                                                    glm::vec3(way / distance_m),
                                                    static_cast<float>(kShare * distance_m))) {
    return std::nullopt;
  }
  const LatLongSize size{other_light_.width, other_light_.height};
  return LatLongFromDirection(way, size) - 0.5;
}

std::string ColourPicker::Press(PictureSide side,
                                const glm::dvec2& pixel,
                                double reach_px,
                                double radius_px) {
  held_.reset();
  if (light_.Empty()) return Describe();
  State before = now_;
  if (now_.way == ColourWay::kChart) {
    const auto corner = now_.charts.at(IndexOf(side)).Take(pixel, reach_px);
    if (!corner) return "the chart has its four corners: drag one of them";
    held_ = Held{side, *corner};
  } else if (const auto near = SurfaceNear(side, pixel, reach_px)) {
    held_ = Held{side, *near};
  } else if (side == PictureSide::kCamera) {
    PickedSurface surface{{pixel, radius_px}, std::nullopt};
    if (other_is_survey_) {
      if (const auto place = PlaceInSurvey(pixel)) {
        surface.other = PickedDisc{*place, std::max(1.0, kSurveyRadiusShare * radius_px)};
      }
    }
    now_.surfaces.push_back(surface);
    held_ = Held{side, now_.surfaces.size() - 1};
  } else {
    if (now_.surfaces.empty()) return "press the surface in the camera's picture first";
    now_.surfaces.back().other = PickedDisc{pixel, radius_px};
    held_ = Held{side, now_.surfaces.size() - 1};
  }
  undo_.Remember(before);
  Fit();
  if (now_.way == ColourWay::kSurfaces && !now_.surfaces[held_->index].other) {
    return "press the same surface in the other picture";
  }
  return Describe();
}

void ColourPicker::MoveTo(const glm::dvec2& pixel) {
  if (!held_) return;
  if (now_.way == ColourWay::kChart) {
    now_.charts.at(IndexOf(held_->side)).Move(held_->index, pixel);
  } else if (held_->side == PictureSide::kOther) {
    now_.surfaces[held_->index].other->at_px = pixel;
  } else {
    PickedSurface& surface = now_.surfaces[held_->index];
    surface.camera.at_px = pixel;
    if (other_is_survey_ && surface.other) {
      if (const auto place = PlaceInSurvey(pixel)) surface.other->at_px = *place;
    }
  }
  Fit();
}

void ColourPicker::LetGo() {
  if (!held_) return;
  held_.reset();
  undo_.Drop(now_);
  Fit();
}

std::string ColourPicker::FindCharts() {
  State found = now_;
  found.way = ColourWay::kChart;
  const bool in_camera = !codes_.Empty() && found.charts[0].Find(codes_);
  const bool in_other = other_shown_ && found.charts[1].Find(*other_shown_);
  undo_.Remember(now_);
  now_ = std::move(found);
  held_.reset();
  Fit();
  if (in_camera && in_other) return Describe();
  return fmt::format("no ColorChecker is found in the {} picture: press its four corners",
                     in_camera ? "other" : "camera's");
}

void ColourPicker::Delete(std::size_t surface) {
  undo_.Remember(now_);
  now_.surfaces.erase(now_.surfaces.begin() + static_cast<std::ptrdiff_t>(surface));
  held_.reset();
  Fit();
}

void ColourPicker::Undo() {
  held_.reset();
  if (undo_.Undo(now_)) Fit();
}

void ColourPicker::Redo() {
  held_.reset();
  if (undo_.Redo(now_)) Fit();
}

std::vector<ColourPair> ColourPicker::Pairs() const {
  std::vector<ColourPair> pairs;
  if (light_.Empty() || other_light_.Empty()) return pairs;
  if (now_.way == ColourWay::kSurfaces) {
    pairs.reserve(now_.surfaces.size());
    for (const PickedSurface& surface : now_.surfaces) {
      if (!surface.other) continue;
      pairs.push_back({MeanOfDisc(light_, surface.camera.at_px, surface.camera.radius_px),
                       MeanOfDisc(other_light_, surface.other->at_px, surface.other->radius_px)});
    }
    return pairs;
  }
  const auto camera = now_.charts[0].Complete();
  const auto other = now_.charts[1].Complete();
  if (!camera || !other) return pairs;
  const auto from = MeasureChart(light_, *camera);
  const auto to = MeasureChart(other_light_, *other);
  pairs.reserve(from.size());
  for (std::size_t i = 0; i < from.size(); ++i) pairs.push_back({from[i].mean, to[i].mean});
  return pairs;
}

void ColourPicker::Fit() {
  tie_.reset();
  try {
    const std::vector<ColourPair> pairs = Pairs();
    if (!pairs.empty()) tie_ = FitColourTie(pairs, ColourTieKind::kScale);
  } catch (const std::exception& error) {
    tie_ = tl::unexpected(std::string(error.what()));
  }
}

bool ColourPicker::HasUnsavedPicks() const {
  return !now_.surfaces.empty() ||
         std::any_of(now_.charts.begin(), now_.charts.end(), [](const ChartMarks& chart) {
           return !chart.Corners().empty();
         });
}

void ColourPicker::Save() {
  ReadResponse();
  if (!tie_ || !*tie_) {
    throw std::runtime_error("colour: expected surfaces or a ColorChecker in both pictures: " +
                             Describe());
  }
  const std::filesystem::path& file = site_->loaded->sequence.file;
  WriteTiedResponse(*response_, **tie_, file, file);
}

}  // namespace pleinair
