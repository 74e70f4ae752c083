#include "apps/imperfection_dials.h"

#include <functional>

namespace pleinair {
namespace {

std::function<void(Imperfections&, double)> Sets(double Imperfections::*field) {
  return [field](Imperfections& imperfections, double size) { imperfections.*field = size; };
}

}  // namespace

std::vector<ImperfectionDial> ImperfectionDials() {
  using I = Imperfections;
  std::vector<ImperfectionDial> dials{
      {"gain",
       "white balance (log)",
       "white balance is off by a factor of exp of",
       "",
       {0.03, 0.06, 0.12, 0.24, 0.48},
       0.12,
       Sets(&I::gain_log_stddev)},
      {"exposure",
       "exposure's wander",
       "exposure is withheld and wanders by",
       "EV",
       {0.1, 0.35, 0.7, 1.0, 1.4},
       0.7,
       Sets(&I::exposure_ev)},
      {"veil",
       "veil, of the mean",
       "flare and haze add to the picture a share of its mean of",
       "",
       {0.004, 0.01, 0.02, 0.04, 0.08},
       0.02,
       Sets(&I::veil_share)},
      {"vignette",
       "corners' loss",
       "corners lose a share of the light of",
       "",
       {0.03, 0.07, 0.15, 0.3, 0.5},
       0.15,
       Sets(&I::vignette_share)},
      {"saturation",
       "saturation",
       "colours are more saturated by",
       "",
       {0.02, 0.07, 0.15, 0.3, 0.6},
       0.15,
       Sets(&I::saturation)},
      {"curve",
       "gamma (log)",
       "the camera's curve has a gamma that is off by a factor of exp of",
       "",
       {0.01, 0.03, 0.06, 0.12, 0.24},
       0.06,
       Sets(&I::curve_log_stddev)},
      {"sharpen",
       "sharpening",
       "the picture is sharpened by",
       "",
       {0.1, 0.2, 0.4, 0.8, 1.6},
       0.4,
       Sets(&I::sharpening)},
      {"jpeg",
       "100 - JPEG quality",
       "JPEG's quality is below 100 by",
       "",
       {4.0, 10.0, 18.0, 35.0, 70.0},
       18.0,
       Sets(&I::jpeg_loss)},
      {"pose_deg",
       "camera turned",
       "the camera is turned by",
       "°",
       {0.05, 0.12, 0.25, 0.5, 1.0},
       0.25,
       Sets(&I::pose_deg)},
      {"pose_m",
       "camera moved",
       "the camera's place is off by",
       "m",
       {0.01, 0.02, 0.04, 0.08, 0.16},
       0.04,
       Sets(&I::pose_m)},
      {"mesh_m",
       "mesh",
       "the mesh's vertices are off by",
       "m",
       {0.01, 0.03, 0.06, 0.12, 0.24},
       0.03,
       Sets(&I::mesh_m)},
      {"north_deg",
       "north",
       "north is off by",
       "°",
       {0.1, 0.3, 0.7, 1.5, 3.0},
       0.7,
       Sets(&I::north_deg)}};
  dials.push_back({"clip",
                   "map clipped at",
                   "the survey map is clipped, in multiples of its brightest sky, at",
                   "",
                   {96.0, 24.0, 6.0, 1.5, 0.5},
                   6.0,
                   [](I& imperfections, double at) { imperfections.map_clipped_at = at; }});
  dials.push_back({"albedo",
                   "albedos (log)",
                   "without a survey map, albedos are off by a factor of exp of",
                   "",
                   {0.05, 0.1, 0.2, 0.4, 0.8},
                   0.2,
                   [](I& imperfections, double size) { imperfections.albedo_log_stddev = size; },
                   true});
  return dials;
}

}  // namespace pleinair
