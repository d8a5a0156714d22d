// SPDX-License-Identifier: MIT
#include "lab/scenes/assembly.h"

typedef struct finish_row {
    const char* name;
    float color[3]; ///< linear
    float metallic, roughness;
} finish_row;

static const finish_row finishes[FINISH_COUNT] = {
    [FINISH_STEEL] = {"steel", {0.42f, 0.43f, 0.45f}, 0.9f, 0.45f},
    [FINISH_STAINLESS] = {"stainless steel", {0.62f, 0.62f, 0.60f}, 1.0f, 0.3f},
    [FINISH_GALVANISED] = {"galvanised steel", {0.50f, 0.52f, 0.53f}, 0.8f, 0.55f},
    [FINISH_CAST_IRON] = {"cast iron", {0.10f, 0.10f, 0.11f}, 0.6f, 0.7f},
    [FINISH_COPPER] = {"copper", {0.72f, 0.31f, 0.16f}, 1.0f, 0.35f},
    [FINISH_BRASS] = {"brass", {0.70f, 0.50f, 0.18f}, 1.0f, 0.35f},
    [FINISH_ALUMINIUM] = {"aluminium", {0.66f, 0.67f, 0.68f}, 0.9f, 0.4f},
    [FINISH_RUBBER] = {"rubber", {0.02f, 0.02f, 0.02f}, 0.0f, 0.9f},
    [FINISH_CONCRETE] = {"concrete", {0.36f, 0.35f, 0.33f}, 0.0f, 0.95f},
    [FINISH_ASPHALT] = {"asphalt", {0.07f, 0.07f, 0.075f}, 0.0f, 0.95f},
    [FINISH_BRICK] = {"brick", {0.32f, 0.12f, 0.08f}, 0.0f, 0.9f},
    [FINISH_INSULATION] = {"pipe insulation", {0.60f, 0.61f, 0.62f}, 0.7f, 0.35f},
    [FINISH_PLASTIC_WHITE] = {"white plastic", {0.78f, 0.78f, 0.76f}, 0.0f, 0.5f},
    [FINISH_PLASTIC_BLACK] = {"black plastic", {0.03f, 0.03f, 0.035f}, 0.0f, 0.5f},
    [FINISH_PAINT_GREY] = {"grey paint", {0.20f, 0.21f, 0.22f}, 0.0f, 0.6f},
    [FINISH_PAINT_LIGHT_GREY] = {"light grey paint", {0.48f, 0.50f, 0.51f}, 0.0f, 0.6f},
    [FINISH_PAINT_BLUE] = {"blue paint", {0.03f, 0.14f, 0.40f}, 0.0f, 0.5f},
    [FINISH_PAINT_GREEN] = {"green paint", {0.05f, 0.25f, 0.13f}, 0.0f, 0.5f},
    [FINISH_PAINT_RED] = {"red paint", {0.50f, 0.03f, 0.02f}, 0.0f, 0.5f},
    [FINISH_PAINT_YELLOW] = {"safety yellow paint", {0.80f, 0.52f, 0.02f}, 0.0f, 0.5f},
    [FINISH_PAINT_ORANGE] = {"orange paint", {0.80f, 0.20f, 0.02f}, 0.0f, 0.45f},
    [FINISH_PAINT_WHITE] = {"white paint", {0.75f, 0.76f, 0.76f}, 0.0f, 0.6f},
    [FINISH_PORCELAIN] = {"porcelain", {0.24f, 0.09f, 0.05f}, 0.0f, 0.2f},
    [FINISH_GLASS] = {"glass", {0.10f, 0.16f, 0.18f}, 0.0f, 0.1f},
    [FINISH_DOUGH] = {"dough", {0.72f, 0.45f, 0.18f}, 0.0f, 0.8f},
    [FINISH_GLAZE] = {"glaze", {0.80f, 0.35f, 0.42f}, 0.0f, 0.3f},
    [FINISH_CARDBOARD] = {"cardboard", {0.45f, 0.30f, 0.16f}, 0.0f, 0.9f},
    [FINISH_WOOD] = {"wood", {0.42f, 0.28f, 0.14f}, 0.0f, 0.85f},
    [FINISH_CAR_RED] = {"red lacquer", {0.55f, 0.02f, 0.02f}, 0.1f, 0.25f},
    [FINISH_CAR_BLUE] = {"blue lacquer", {0.02f, 0.08f, 0.38f}, 0.1f, 0.25f},
    [FINISH_CAR_SILVER] = {"silver lacquer", {0.55f, 0.56f, 0.58f}, 0.6f, 0.3f},
    [FINISH_CAR_PRIMER] = {"primer", {0.28f, 0.30f, 0.28f}, 0.0f, 0.7f},
    [FINISH_UPHOLSTERY] = {"upholstery", {0.06f, 0.055f, 0.05f}, 0.0f, 0.95f},
    [FINISH_GRASS] = {"grass", {0.10f, 0.17f, 0.05f}, 0.0f, 0.95f},
    [FINISH_LAMP] = {"lamp", {0.90f, 0.90f, 0.82f}, 0.0f, 0.4f},
};

stp_material plan_material(plan_finish finish)
{
    const finish_row* row = &finishes[finish];
    stp_material material = stp_material_default();
    material.name = row->name;
    for (int i = 0; i < 3; ++i) {
        material.base_color[i] = row->color[i];
    }
    material.metallic = row->metallic;
    material.roughness = row->roughness;
    if (finish == FINISH_LAMP) {
        material.emissive[0] = material.emissive[1] = material.emissive[2] = 1.0f;
    }
    return material;
}
