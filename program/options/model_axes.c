// SPDX-License-Identifier: MIT
#include "program/options/model_axes.h"

#include <assert.h>

const char* const model_up_names[MODEL_UPS] = {"x", "-x", "y", "-y", "z", "-z"};
const char model_up_axes[MODEL_UPS] = {'x', 'X', 'y', 'Y', 'z', 'Z'};
const char* const model_unit_names[MODEL_UNITS] = {"m", "mm", "cm", "in", "ft", "us-ft"};
const double model_unit_metres[MODEL_UNITS] = {1.0, 0.001, 0.01, 0.0254, 0.3048, 1200.0 / 3937.0};

char model_axes_up(const model_axes* axes)
{
    assert(axes->up >= 0 && axes->up < MODEL_UPS);
    return axes->has_up ? model_up_axes[axes->up] : '\0';
}

double model_axes_unit(const model_axes* axes)
{
    assert(axes->unit >= 0 && axes->unit < MODEL_UNITS);
    return axes->has_unit ? model_unit_metres[axes->unit] : 0.0;
}
