#include "apps/viewer/response_picker.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

#include "apps/chart_greys.h"
#include "apps/site_response.h"
#include "calib/bracket_fit.h"
#include "scene/upper_median.h"

namespace pleinair {
namespace {

// The light that a code stands for, between codes linearly.
double LightOf(const std::array<float, 256>& linear_of_code, double code) {
  const auto below = static_cast<std::size_t>(std::clamp(code, 0.0, 254.0));
  const double part = code - static_cast<double>(below);
  return (1.0 - part) * linear_of_code[below] + part * linear_of_code[below + 1];
}

// How a picture's greys lie to the curve, all channels together; `scale` is the curve's light for
// a sample's light of 1.
TakenResidual ResidualOf(const GreySamples& samples,
                         const ResponseTable& table,
                         const std::array<double, 3>& scale) {
  std::vector<double> errors;
  for (std::size_t c = 0; c < samples.size(); ++c) {
    errors.reserve(errors.size() + samples[c].size());
    for (const ResponseSample& sample : samples[c]) {
      errors.push_back(std::log(LightOf(table[c], sample.code) / (scale[c] * sample.light)));
    }
  }
  TakenResidual residual;
  if (errors.empty()) {
    residual.left_out = "no grey of the chart is between black and white";
    return residual;
  }
  const double middle = UpperMedian(errors);
  for (double& error : errors) error = std::abs(error - middle);
  residual.is_compared = true;
  residual.offset_relative = std::expm1(middle);
  residual.scatter_relative = UpperMedian(errors);
  return residual;
}

}  // namespace

void ResponsePicker::SetWay(ResponseWay way) {
  if (way == now_.way) return;
  undo_.Remember(now_);
  now_.way = way;
  held_.reset();
  Fit();
}

std::string ResponsePicker::Describe() const {
  if (found_ && !*found_) return found_->error();
  if (found_) {
    const auto& channels = (*found_)->channels;
    return fmt::format("off by {:.1f} %, {:.1f} %, {:.1f} % rms (red, green, blue); codes {} to {}",
                       100.0 * channels[0].rms_relative,
                       100.0 * channels[1].rms_relative,
                       100.0 * channels[2].rms_relative,
                       channels[1].lowest_code,
                       channels[1].highest_code);
  }
  if (now_.way == ResponseWay::kChart) {
    if (std::string missing = now_.chart.Missing(); !missing.empty()) return missing;
    return "take pictures of the chart, at several exposures";
  }
  return fmt::format("{} of 2 pictures: take the same view at several exposures",
                     now_.pictures.size());
}

std::string ResponsePicker::Take(const ViewedFrame& frame, std::optional<double> stated_exposure) {
  if (!frame.step.frame || !frame.step.frame->codes) {
    return "response: expected an 8-bit picture of the camera, found a linear one";
  }
  const Frame& seen = *frame.step.frame;
  TakenPicture taken;
  taken.name = fmt::format("frame {}", seen.index);
  taken.exposure = stated_exposure ? stated_exposure : seen.exposure;
  taken.codes = std::make_shared<const Rgb8Image>(*seen.codes);
  if (!taken.exposure && now_.way == ResponseWay::kBracket) {
    return "response: the picture's exposure is not known: state it in the panel Tools";
  }
  undo_.Remember(now_);
  held_.reset();
  now_.pictures.push_back(std::move(taken));
  Fit();
  return Describe();
}

void ResponsePicker::Delete(std::size_t picture) {
  undo_.Remember(now_);
  held_.reset();
  now_.pictures.erase(now_.pictures.begin() + static_cast<std::ptrdiff_t>(picture));
  Fit();
}

std::string ResponsePicker::Press(const glm::dvec2& pixel, double reach_px) {
  held_.reset();
  if (now_.way != ResponseWay::kChart) return "a bracket needs no picks: take pictures";
  const State before = now_;
  held_ = now_.chart.Take(pixel, reach_px);
  if (!held_) return "the chart has its four corners: drag one of them";
  undo_.Remember(before);
  return Describe();
}

void ResponsePicker::MoveTo(const glm::dvec2& pixel) {
  if (held_) now_.chart.Move(*held_, pixel);
}

void ResponsePicker::Release() {
  if (!held_) return;
  held_.reset();
  Fit();
}

// Press did not fit: the curve is that of what comes back.
void ResponsePicker::LetGo() {
  if (!held_) return;
  held_.reset();
  undo_.Drop(now_);
}

std::string ResponsePicker::FindChart(const Rgb8Image& picture) {
  State found = now_;
  found.way = ResponseWay::kChart;
  const bool is_found = found.chart.Find(picture);
  undo_.Remember(now_);
  now_ = std::move(found);
  held_.reset();
  Fit();
  return is_found ? Describe() : "no ColorChecker is found: press its four corners";
}

void ResponsePicker::Undo() {
  held_.reset();
  if (undo_.Undo(now_)) Fit();
}

void ResponsePicker::Redo() {
  held_.reset();
  if (undo_.Redo(now_)) Fit();
}

void ResponsePicker::Fit() {
  found_.reset();
  residuals_.clear();
  try {
    if (now_.way == ResponseWay::kBracket) {
      FitByBracket();
    } else {
      FitByChart();
    }
  } catch (const std::exception& error) {
    found_ = tl::unexpected(std::string(error.what()));
  }
}

void ResponsePicker::FitByBracket() {
  constexpr std::size_t kFewest = 2;
  if (now_.pictures.size() < kFewest) return;
  std::vector<ExposedPicture> pictures;
  pictures.reserve(now_.pictures.size());
  for (const TakenPicture& taken : now_.pictures) {
    if (!taken.exposure) {
      throw std::runtime_error("response: " + taken.name + ": its exposure is not known");
    }
    pictures.push_back({*taken.codes, *taken.exposure});
  }
  BracketFit fit = FitBracket(pictures);
  residuals_.reserve(fit.pictures.size());
  for (BracketPicture& picture : fit.pictures) {
    residuals_.push_back({picture.is_compared,
                          std::expm1(picture.offset),
                          picture.scatter,
                          std::move(picture.reason)});
  }
  found_ = fit.response;
}

void ResponsePicker::FitByChart() {
  const auto corners = now_.chart.Complete();
  if (!corners || now_.pictures.empty()) return;
  GreySamples all;
  std::vector<GreySamples> of_pictures;
  of_pictures.reserve(now_.pictures.size());
  for (const TakenPicture& taken : now_.pictures) {
    // One picture alone needs no exposure: its light has no unit.
    if (!taken.exposure && now_.pictures.size() > 1) {
      throw std::runtime_error("response: " + taken.name + ": its exposure is not known");
    }
    const double exposure = now_.pictures.size() > 1 ? *taken.exposure : 1.0;
    GreySamples& samples = of_pictures.emplace_back();
    AddGreys(MeasureChart(*taken.codes, *corners), exposure, samples);
    for (std::size_t c = 0; c < all.size(); ++c) {
      all[c].insert(all[c].end(), samples[c].begin(), samples[c].end());
    }
  }
  ResponseFit fit = FitMonotoneResponse(all);
  std::array<double, 3> scale{};
  for (std::size_t c = 0; c < all.size(); ++c) {
    std::vector<double> ratios;
    ratios.reserve(all[c].size());
    for (const ResponseSample& sample : all[c]) {
      ratios.push_back(LightOf(fit.table[c], sample.code) / sample.light);
    }
    scale[c] = UpperMedian(ratios);
  }
  residuals_.reserve(of_pictures.size());
  for (const GreySamples& samples : of_pictures) {
    residuals_.push_back(ResidualOf(samples, fit.table, scale));
  }
  found_ = fit;
}

bool ResponsePicker::HasUnsavedPicks() const {
  return !(now_.pictures.empty() && now_.chart.Corners().empty()) && now_ != saved_;
}

void ResponsePicker::Save() {
  Release();
  if (!found_ || !*found_) throw std::runtime_error("response: no curve yet: " + Describe());
  const std::filesystem::path& file = site_->loaded->sequence.file;
  WriteSiteResponse(ResponseCurve::FromTable((*found_)->table).FileText(), file, file);
  saved_ = now_;
}

}  // namespace pleinair
