#include "apps/imperfection_dials.h"

#include <utility>

namespace pleinair {
namespace {

ImperfectionDial Dial(std::string name,
                      std::string words,
                      std::string unit,
                      std::vector<double> sizes,
                      double usual,
                      double Imperfections::*field) {
  return {std::move(name),
          std::move(words),
          std::move(unit),
          std::move(sizes),
          usual,
          [field](Imperfections& imperfections, double size) { imperfections.*field = size; }};
}

}  // namespace

std::vector<ImperfectionDial> ImperfectionDials() {
  using I = Imperfections;
  std::vector<ImperfectionDial> dials{
      Dial("gain",
           "white balance is off by a factor of exp of",
           "",
           {0.03, 0.06, 0.12, 0.24, 0.48},
           0.12,
           &I::gain_log_stddev),
      Dial("exposure",
           "exposure is withheld and wanders by",
           "EV",
           {0.1, 0.35, 0.7, 1.0, 1.4},
           0.7,
           &I::exposure_ev),
      Dial("veil",
           "flare and haze add to the picture a share of its mean of",
           "",
           {0.004, 0.01, 0.02, 0.04, 0.08},
           0.02,
           &I::veil_share),
      Dial("vignette",
           "corners lose a share of the light of",
           "",
           {0.03, 0.07, 0.15, 0.3, 0.5},
           0.15,
           &I::vignette_share),
      Dial("saturation",
           "colours are more saturated by",
           "",
           {0.02, 0.07, 0.15, 0.3, 0.6},
           0.15,
           &I::saturation),
      Dial("curve",
           "the camera's curve has a gamma that is off by a factor of exp of",
           "",
           {0.01, 0.03, 0.06, 0.12, 0.24},
           0.06,
           &I::curve_log_stddev),
      Dial("sharpen",
           "the picture is sharpened by",
           "",
           {0.1, 0.2, 0.4, 0.8, 1.6},
           0.4,
           &I::sharpening),
      Dial("jpeg",
           "JPEG's quality is below 100 by",
           "",
           {4.0, 10.0, 18.0, 35.0, 70.0},
           18.0,
           &I::jpeg_loss),
      Dial("pose_deg",
           "the camera is turned by",
           "°",
           {0.05, 0.12, 0.25, 0.5, 1.0},
           0.25,
           &I::pose_deg),
      Dial("pose_m",
           "the camera's place is off by",
           "m",
           {0.01, 0.02, 0.04, 0.08, 0.16},
           0.04,
           &I::pose_m),
      Dial("mesh_m",
           "the mesh's vertices are off by",
           "m",
           {0.01, 0.03, 0.06, 0.12, 0.24},
           0.03,
           &I::mesh_m),
      Dial("north_deg", "north is off by", "°", {0.1, 0.3, 0.7, 1.5, 3.0}, 0.7, &I::north_deg)};
  dials.push_back({"clip",
                   "the survey map is clipped, in multiples of its brightest sky, at",
                   "",
                   {96.0, 24.0, 6.0, 1.5, 0.5},
                   6.0,
                   [](I& imperfections, double at) { imperfections.map_clipped_at = at; }});
  dials.push_back({"albedo",
                   "without a survey map, albedos are off by a factor of exp of",
                   "",
                   {0.05, 0.1, 0.2, 0.4, 0.8},
                   0.2,
                   [](I& imperfections, double size) { imperfections.albedo_log_stddev = size; },
                   true});
  return dials;
}

}  // namespace pleinair
