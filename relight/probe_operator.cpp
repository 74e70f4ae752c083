#include "relight/probe_operator.h"
