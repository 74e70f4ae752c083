// The camera's response from pictures that a person takes in the window: an exposure bracket, or a
// ColorChecker.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <glm/vec2.hpp>
#include <tl/expected.hpp>

#include "apps/viewer/chart_marks.h"
#include "apps/viewer/frame_worker.h"
#include "apps/viewer/undo_stack.h"
#include "calib/response_fit.h"

namespace pleinair {

enum class ResponseWay { kBracket, kChart };

// A picture that was taken, and what the curve leaves of it.
struct TakenPicture {
  std::string name;
  std::optional<double> exposure;  // None: not stated.
  std::shared_ptr<const Rgb8Image> codes;

  bool operator==(const TakenPicture&) const = default;
};

// How a taken picture agrees with the curve.
struct TakenResidual {
  bool is_compared = false;       // Else the two numbers are not measured.
  double offset_relative = 0.0;   // Offset of its light.
  double scatter_relative = 0.0;  // About that.
  std::string left_out;           // Why; empty: it counts.
};

class ResponsePicker {
 public:
  explicit ResponsePicker(std::shared_ptr<const ViewedSite> site) : site_(std::move(site)) {}

  ResponseWay Way() const { return now_.way; }
  void SetWay(ResponseWay way);
  const std::vector<TakenPicture>& Pictures() const { return now_.pictures; }
  // One for all pictures: the camera stands still.
  const ChartMarks& Chart() const { return now_.chart; }
  // The curve by the pictures; none with too few.
  const std::optional<tl::expected<ResponseFit, std::string>>& Found() const { return found_; }
  const std::vector<TakenResidual>& Residuals() const { return residuals_; }  // A picture each.
  std::string Describe() const;

  // The frame's picture at its exposure, or at the stated one. Returns why not, in a line.
  std::string Take(const ViewedFrame& frame, std::optional<double> stated_exposure);
  void Delete(std::size_t picture);
  // The corner of the chart within reach, or the next one. Returns why not, in a line.
  std::string Press(const glm::dvec2& pixel, double reach_px);
  void MoveTo(const glm::dvec2& pixel);
  // Fits: not while a corner moves.
  void Release();
  // In place of Release: all is as before Press.
  void LetGo();
  // Returns why not, in a line.
  std::string FindChart(const Rgb8Image& picture);
  void Undo();
  void Redo();

  // Whether there are pictures or corners that Save has not yet written a curve of.
  bool HasUnsavedPicks() const;
  // As the response of the site's camera, of what is shown. Throws std::runtime_error, one line.
  void Save();

 private:
  struct State {
    ResponseWay way = ResponseWay::kBracket;
    std::vector<TakenPicture> pictures;
    ChartMarks chart;

    bool operator==(const State&) const = default;
  };

  void Fit();
  void FitByBracket();
  void FitByChart();

  std::shared_ptr<const ViewedSite> site_;
  State now_;
  State saved_;
  UndoStack<State> undo_;
  std::optional<std::size_t> held_;
  std::optional<tl::expected<ResponseFit, std::string>> found_;
  std::vector<TakenResidual> residuals_;
};

}  // namespace pleinair
