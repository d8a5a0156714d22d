// SPDX-License-Identifier: MIT
//
// A plan of an assembly before any triangle is made: its meshes (each a recipe of shapes) and their
// placement (line > station > module > part). Triangles are counted by formulas, fitted to the
// wanted totals, and only then made.
//
//   plan_begin -> plan_add_mesh, plan_group, plan_part, plan_use ... -> plan_fit -> plan_build
//
// A plan that runs out of memory records the failure; adding needs no checks.
#pragma once

#include "lab/scenes/mesh_shapes.h"
#include "lab/scenes/scenes.h"

enum { PLAN_PARAMETERS = 10 };

/// Makes a part at the origin from the parameters of its mesh.
typedef void (*part_maker)(shaper* s, const double* p);

typedef struct plan_mesh {
    const char* name;
    part_maker make;
    double parameters[PLAN_PARAMETERS];
    uint64_t seed;
    uint32_t material;  ///< a plan_finish
    uint64_t uses;      ///< in the whole assembly
    uint64_t designed;  ///< triangles at detail 1
    uint64_t triangles; ///< as fitted
    uint64_t vertices;
    double detail;
    bool sparse; ///< at small scales, shapes may be left out
} plan_mesh;

typedef struct plan_object {
    const char* name;
    uint32_t parent; ///< STP_NONE: the assembly itself
    stp_affine transform;
    uint32_t mesh; ///< STP_NONE: a group
    uint32_t use;  ///< a prototype of lower index; STP_NONE: none
    bool prototype;
} plan_object;

typedef struct plan_counts {
    uint64_t objects, unique_objects, triangles, unique_triangles;
} plan_counts;

typedef struct assembly_plan {
    stp_context* context;
    uint64_t seed;
    /// Above it a mesh is common (plan_fit); 0: the mean, weighted by triangles
    double common_uses;
    stp_arena text;
    plan_mesh* meshes;
    plan_object* objects;
    size_t mesh_count, object_count, mesh_capacity, object_capacity;
    bool failed;
} assembly_plan;

/// Materials and paints.
typedef enum plan_finish {
    FINISH_STEEL,
    FINISH_STAINLESS,
    FINISH_GALVANISED,
    FINISH_CAST_IRON,
    FINISH_COPPER,
    FINISH_BRASS,
    FINISH_ALUMINIUM,
    FINISH_RUBBER,
    FINISH_CONCRETE,
    FINISH_ASPHALT,
    FINISH_BRICK,
    FINISH_INSULATION,
    FINISH_PLASTIC_WHITE,
    FINISH_PLASTIC_BLACK,
    FINISH_PAINT_GREY,
    FINISH_PAINT_LIGHT_GREY,
    FINISH_PAINT_BLUE,
    FINISH_PAINT_GREEN,
    FINISH_PAINT_RED,
    FINISH_PAINT_YELLOW,
    FINISH_PAINT_ORANGE,
    FINISH_PAINT_WHITE,
    FINISH_PORCELAIN,
    FINISH_GLASS,
    FINISH_DOUGH,
    FINISH_GLAZE,
    FINISH_CARDBOARD,
    FINISH_WOOD,
    FINISH_CAR_RED,
    FINISH_CAR_BLUE,
    FINISH_CAR_SILVER,
    FINISH_CAR_PRIMER,
    FINISH_UPHOLSTERY,
    FINISH_GRASS,
    FINISH_LAMP,
    FINISH_COUNT,
} plan_finish;

void plan_begin(assembly_plan* plan, stp_context* context, uint64_t seed);
void plan_end(assembly_plan* plan);

/// A text of the plan.
const char* plan_text(assembly_plan* plan, const char* format, ...)
    __attribute__((format(printf, 2, 3)));
/// Adds a mesh without placing it. Missing parameters are 0. @return its index
uint32_t plan_add_mesh(assembly_plan* plan, const char* name, plan_finish finish, part_maker make,
                       const double parameters[PLAN_PARAMETERS]);
/// The parameters of a recipe.
#define PARAMETERS(...) ((const double[PLAN_PARAMETERS]){__VA_ARGS__})

uint32_t plan_group(assembly_plan* plan, uint32_t parent, const char* name, stp_affine transform);
/// A group that is visible only where it is used.
uint32_t plan_prototype(assembly_plan* plan, const char* name);
void plan_use(assembly_plan* plan, uint32_t parent, const char* name, uint32_t prototype,
              stp_affine transform);
/// Places a mesh.
void plan_place(assembly_plan* plan, uint32_t parent, const char* name, uint32_t mesh,
                stp_affine transform);
/// Adds a mesh and places it once.
void plan_part(assembly_plan* plan, uint32_t parent, const char* name, plan_finish finish,
               part_maker make, const double parameters[PLAN_PARAMETERS], stp_affine transform);

plan_counts plan_count(const assembly_plan* plan);
/// Fits the detail of each mesh so that the totals are `scale` times the wanted ones. Rarely used
/// and common meshes each get a factor of their own. Counts are by formula; runs on all threads.
void plan_fit(assembly_plan* plan, const plan_counts* wanted, double scale);
/// Adds everything below `parent`. @return STP_OK, STP_ERROR_OUT_OF_MEMORY, STP_ERROR_CANCELLED
STP_MUST_USE stp_result plan_build(assembly_plan* plan, stp_scene* scene, uint32_t parent,
                                   const char* name, const stp_affine* place, uint32_t* object);
/// The material of a finish.
stp_material plan_material(plan_finish finish);
