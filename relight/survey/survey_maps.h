// The survey as pictures: the paper's offline maps (jensen-2006, figure 4), to look at and to
// check.
#pragma once

#include "relight/survey/survey.h"
#include "scene/image.h"

namespace pleinair {

// Lat-long, of the survey map's size; grey maps have three equal channels; zero where no surface
// is.
struct SurveyMaps {
  RgbImage albedo_rgb;
  RgbImage normal_world;
  RgbImage ambient_weight;  // c of a uniform sky, without bounces; an open vertical wall has 0.5.
  RgbImage sun_visibility;  // Share of the disc seen, at the time of the survey.
  RgbImage sky_radiance;    // Without the disc, what buildings hide filled in.
  RgbImage skyline;         // Share of the sky that is hidden though the mesh lacks what hides it.
  RgbImage relit;           // The map under its own light, without the disc.
};

SurveyMaps MakeSurveyMaps(const Survey& survey);

}  // namespace pleinair
