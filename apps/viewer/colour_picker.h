// The camera's colours tied to the survey's, or to another camera's, by surfaces or a ColorChecker
// that a person picks in both pictures.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <glm/vec2.hpp>
#include <tl/expected.hpp>

#include "apps/viewer/chart_marks.h"
#include "apps/viewer/frame_worker.h"
#include "apps/viewer/picture_side.h"
#include "apps/viewer/undo_stack.h"
#include "calib/colour_tie.h"

namespace pleinair {

// What both pictures show.
enum class ColourWay { kSurfaces, kChart };

// A disc in a picture.
struct PickedDisc {
  glm::dvec2 at_px{0.0};
  double radius_px = 0.0;

  bool operator==(const PickedDisc&) const = default;
};

// One surface, in the camera's picture and, once it is known there, in the other one.
struct PickedSurface {
  PickedDisc camera;
  std::optional<PickedDisc> other;

  bool operator==(const PickedSurface&) const = default;
};

class ColourPicker {
 public:
  // The other picture is the site's survey map, where it has one.
  explicit ColourPicker(std::shared_ptr<const ViewedSite> site);

  // The same site, read again: its camera may have another response.
  void SetSite(std::shared_ptr<const ViewedSite> site);
  // Measures in this picture of the camera from now on.
  void Look(const ViewedFrame& frame);
  // Another picture in place of the survey map, or of one that cannot be read: an 8-bit one is
  // taken to be sRGB. Throws as ReadLinear.
  void OpenOther(const std::filesystem::path& file);
  // As a screen shows it, another one for each picture that is opened; null: none.
  const std::shared_ptr<const Rgb8Image>& OtherShown() const { return other_shown_; }

  ColourWay Way() const { return now_.way; }
  void SetWay(ColourWay way);
  const std::vector<PickedSurface>& Surfaces() const { return now_.surfaces; }
  const ChartMarks& Chart(PictureSide side) const { return now_.charts.at(IndexOf(side)); }
  // The tie of the pairs; none without a pair. Its residuals are in the order of Surfaces that are
  // in both pictures, or of the chart's patches.
  const std::optional<tl::expected<ColourTie, std::string>>& Tie() const { return tie_; }
  // The residual of surface `index`; none: it is not in both pictures, or there is no tie.
  struct Residual {
    double relative = 0.0;
    bool counts = true;
  };
  std::optional<Residual> ResidualOf(std::size_t index) const;
  std::string Describe() const;

  // Takes the mark within reach, or sets a new one. In the camera's picture that is a new surface,
  // with its place in the survey map by the mesh; in the other picture it is the last surface's.
  // Returns why not, in a line.
  std::string Press(PictureSide side, const glm::dvec2& pixel, double reach_px, double radius_px);
  // The mark that was taken, until Release, or until LetGo, after which all is as before Press.
  void MoveTo(const glm::dvec2& pixel);
  void Release() { held_.reset(); }
  void LetGo();
  // Charts that OpenCV finds, in both pictures. Returns why not, in a line.
  std::string FindCharts();
  void Delete(std::size_t surface);
  void Undo();
  void Redo();

  // Whether there are surfaces or corners: Save ends the picker.
  bool HasUnsavedPicks() const;
  // Multiplies the response of the site's camera, as it is in the site's files now, by the tie.
  // Throws std::runtime_error, one line.
  void Save();

 private:
  struct State {
    ColourWay way = ColourWay::kSurfaces;
    std::vector<PickedSurface> surfaces;
    std::array<ChartMarks, 2> charts;
  };
  struct Held {
    PictureSide side = PictureSide::kCamera;
    std::size_t index = 0;
  };

  static std::size_t IndexOf(PictureSide side) { return static_cast<std::size_t>(side); }
  std::optional<std::size_t> SurfaceNear(PictureSide side,
                                         const glm::dvec2& pixel,
                                         double reach_px) const;
  // Where the survey map shows the surface; none: not from where that was taken.
  std::optional<glm::dvec2> PlaceInSurvey(const glm::dvec2& pixel) const;
  void OpenSurvey();
  void ReadResponse();
  // The light of the picture that is looked at, by the response.
  void Measure();
  // In a line; empty: it is measured, or there is no picture yet.
  std::string WhyUnmeasured() const;
  std::vector<ColourPair> Pairs() const;
  void Fit();

  std::shared_ptr<const ViewedSite> site_;
  // The site's camera's curve, or why it cannot be read.
  tl::expected<ResponseCurve, std::string> response_ = tl::unexpected(std::string());
  std::optional<Camera> camera_;  // The camera of the picture that is looked at.
  std::int64_t looked_at_ = 0;    // That frame's number.
  Rgb8Image codes_;               // Empty: the picture is linear, or there is none yet.
  RgbImage light_;                // Empty: see WhyUnmeasured.
  RgbImage other_light_;
  std::shared_ptr<const Rgb8Image> other_shown_;
  bool other_is_survey_ = false;
  std::string why_no_survey_;  // Why the site's map cannot be read; empty: it can, or has none.
  State now_;
  UndoStack<State> undo_;
  std::optional<Held> held_;
  std::optional<tl::expected<ColourTie, std::string>> tie_;
};

}  // namespace pleinair
