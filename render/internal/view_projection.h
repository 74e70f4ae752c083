// Transforms the camera's pixels to OpenGL's clip space: the only conversion between OpenCV's pixel
// centres and OpenGL's.
#pragma once

#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>

#include "scene/camera.h"

namespace pleinair {

// OpenGL counts from a pixel's corner, OpenCV from its centre: pixel (0, 0) has its centre at
// window point (0.5, 0.5). Rows are not turned: window row 0 is the picture's top row, so that
// textures and what is read back have the layout of Image.
constexpr glm::dvec2 WindowFromPixel(const glm::dvec2& pixel) { return pixel + 0.5; }

// Clip from camera coordinates of an undistorted camera, near plane at `near_m`, none far away:
// points at infinity (w = 0) are drawn.
//
// Windings   Because rows are not turned, what is counter-clockwise to the eye is clockwise to
//            OpenGL: the front face is GL_CW.
glm::dmat4 ClipFromCamera(const CameraIntrinsics& intrinsics, double near_m);

// Makes the pixels lower <= (x, y) < upper of that picture fill the viewport: to be put before a
// clip matrix.
glm::dmat4 ClipOfRect(const CameraIntrinsics& intrinsics,
                      const glm::ivec2& lower,
                      const glm::ivec2& upper);

}  // namespace pleinair
