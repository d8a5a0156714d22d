// SPDX-License-Identifier: MIT
// The section of the Display panel that corrects up axis and unit of a model.
#include "program/options/model_axes.h"
#include "program/viewer/panels/panels.h"
#include "program/viewer/window/gui.h"

void model_page_show(viewer* v)
{
    static const char* const ups[MODEL_UPS + 1] = {
        "As in the file", "X", "-X", "Y", "-Y", "Z", "-Z"};
    static const char* const units[MODEL_UNITS + 1] = {
        "As in the file", "m", "mm", "cm", "in", "ft", "us-ft"};
    static const char built[] = "This file is built: up axis and unit are options of build";
    bool can = v->can_correct;
    int up = 0, unit = 0;
    for (int i = 0; i < MODEL_UPS; ++i) {
        up = v->up == model_up_axes[i] ? i + 1 : up;
    }
    for (int i = 0; i < MODEL_UNITS; ++i) {
        unit = v->unit_metres == model_unit_metres[i] ? i + 1 : unit;
    }
    gui_disable(!can);
    bool changed = gui_choice("Up axis", &up, ups, MODEL_UPS + 1,
                              can ? "The axis of the model that points up, if its file is wrong "
                                    "or does not say. The model is opened again"
                                  : built);
    changed = gui_choice("Model unit", &unit, units, MODEL_UNITS + 1,
                         can ? "The unit of the model, if its file is wrong or does not say. The "
                               "model is opened again"
                             : built) ||
              changed;
    gui_enable();
    if (changed && can) {
        viewer_correct(v, up > 0 ? model_up_axes[up - 1] : '\0',
                       unit > 0 ? model_unit_metres[unit - 1] : 0.0);
    }
}
