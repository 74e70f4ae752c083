// Some of a recording's frames, spread evenly over it.
#pragma once

namespace pleinair {

// Whether frame `index` of `count` is the middle of one of `parts` equal parts. All are where there
// are not more frames than parts.
inline bool IsMiddleOfAPart(int index, int count, int parts) {
  if (count <= parts) return true;
  for (int part = 0; part < parts; ++part) {
    if (index == (2 * part + 1) * count / (2 * parts)) return true;
  }
  return false;
}

}  // namespace pleinair
