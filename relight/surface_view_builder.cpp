#include "relight/surface_view_builder.h"
