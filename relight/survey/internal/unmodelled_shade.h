// Shade in a survey's map that the mesh does not cast: of trees, bridges, houses that it lacks.
#pragma once

#include <cstddef>

#include <glm/vec3.hpp>

#include "relight/survey/internal/shadow_side.h"
#include "scene/image.h"
#include "scene/surface_view.h"

namespace pleinair {

struct UnmodelledShadeInput {
  const RgbImage& radiance;
  // Over the map: geometry, sky_response of the survey's own sky, sun_bounce.
  const SurfaceView& view;
  const Image<ShadowSide>& side;
  glm::vec3 sun_irradiance_rgb{0.0f};  // Normal to the beam.
  glm::vec3 sky_irradiance_rgb{0.0f};
};

struct UnmodelledShade {
  // Shape  of the map. 1 where the sun is hidden from a surface that the mesh has in the sun, and
  //        in the blur of the edge of such shade.
  Gray8Image is_in_shade;
  // Shape  of the map; there its albedo without the sun, scaled to meet that of the lit surface
  //        across the edges. In the blur, the lit surface's.
  RgbImage albedo_rgb;
  std::size_t pixels = 0;
};

// The edge of a shadow has a known step: from sun and sky to the sky alone, in each channel. A
// surface's own dark parts mostly have another level or, as the sky is bluer than the sun, another
// colour. So pixels of one plane are compared across eight pixels of a map of 1024. Where the
// darker one is darker and bluer by that step, it is in shade, and so is what is connected to it
// and as dark and blue. The level may be off by -30 to +80 %, as what hides the sun hides sky too.
// Such a part counts from 64 pixels on, if three tenths of its border are such steps. Their medians
// must have the step's colour: 0.85 to 1.3 of its hue, and its green to 6 %.
//
// Nothing is found where sun and sky have one colour (less than 20 % between red and blue), nor
// shade finer than the map's pixels. A dark surface beside a warm one that differs from it by just
// this step is found wrongly, as colours cannot distinguish it from shade. An example is grey
// asphalt of a sixth of the albedo of brown paving.
UnmodelledShade FindUnmodelledShade(const UnmodelledShadeInput& input);

}  // namespace pleinair
