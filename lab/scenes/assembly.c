// SPDX-License-Identifier: MIT
#include "lab/scenes/assembly.h"

#include "base/math/rng.h"

#include <assert.h>
#include <stdio.h>
#include <string.h>

#define TEXT_BLOCK_SIZE ((size_t)32 << 10)

void plan_begin(assembly_plan* plan, stp_context* context, uint64_t seed)
{
    memset(plan, 0, sizeof(*plan));
    plan->context = context;
    plan->seed = seed;
    plan->text = stp_arena_create(context, TEXT_BLOCK_SIZE);
}

void plan_end(assembly_plan* plan)
{
    stp_free(plan->context, plan->meshes);
    stp_free(plan->context, plan->objects);
    stp_arena_destroy(&plan->text);
}

const char* plan_text(assembly_plan* plan, const char* format, ...)
{
    char text[128];
    va_list arguments;
    va_start(arguments, format);
    int length = vsnprintf(text, sizeof(text), format, arguments);
    va_end(arguments);
    size_t kept = length < 0                      ? 0
                  : (size_t)length < sizeof(text) ? (size_t)length
                                                  : sizeof(text) - 1;
    const char* copy = stp_arena_copy_text(&plan->text, text, kept);
    plan->failed = plan->failed || copy == NULL;
    return copy;
}

uint32_t plan_add_mesh(assembly_plan* plan, const char* name, plan_finish finish, part_maker make,
                       const double parameters[PLAN_PARAMETERS])
{
    if (!STP_MAKE_ROOM(plan->context, plan->meshes, plan->mesh_capacity, plan->mesh_count + 1)) {
        plan->failed = true;
        return STP_NONE;
    }
    plan_mesh* mesh = &plan->meshes[plan->mesh_count];
    *mesh = (plan_mesh){.name = name, .make = make, .material = (uint32_t)finish, .detail = 1.0};
    mesh->seed = stp_rng_hash(plan->seed, plan->mesh_count);
    for (int i = 0; i < PLAN_PARAMETERS; ++i) {
        // as built: no two parts are alike. Lengths vary by a thousandth, counts stay
        double chance = (double)(stp_rng_hash(mesh->seed, (uint64_t)i) >> 11) / 9007199254740992.0;
        mesh->parameters[i] = parameters[i] * (1.0 + 1e-3 * chance);
    }
    return (uint32_t)plan->mesh_count++;
}

static uint32_t add_object(assembly_plan* plan, const plan_object* object)
{
    if (!STP_MAKE_ROOM(plan->context, plan->objects, plan->object_capacity,
                       plan->object_count + 1)) {
        plan->failed = true;
        return STP_NONE;
    }
    plan->objects[plan->object_count] = *object;
    return (uint32_t)plan->object_count++;
}

uint32_t plan_group(assembly_plan* plan, uint32_t parent, const char* name, stp_affine transform)
{
    return add_object(plan, &(plan_object){name, parent, transform, STP_NONE, STP_NONE, false});
}

uint32_t plan_prototype(assembly_plan* plan, const char* name)
{
    plan_object object = {name, STP_NONE, stp_affine_identity(), STP_NONE, STP_NONE, true};
    return add_object(plan, &object);
}

void plan_use(assembly_plan* plan, uint32_t parent, const char* name, uint32_t prototype,
              stp_affine transform)
{
    assert(plan->failed || plan->objects[prototype].prototype);
    add_object(plan, &(plan_object){name, parent, transform, STP_NONE, prototype, false});
}

void plan_place(assembly_plan* plan, uint32_t parent, const char* name, uint32_t mesh,
                stp_affine transform)
{
    assert(plan->failed || mesh < plan->mesh_count);
    add_object(plan, &(plan_object){name, parent, transform, mesh, STP_NONE, false});
}

void plan_part(assembly_plan* plan, uint32_t parent, const char* name, plan_finish finish,
               part_maker make, const double parameters[PLAN_PARAMETERS], stp_affine transform)
{
    plan_place(plan, parent, name, plan_add_mesh(plan, name, finish, make, parameters), transform);
}

// How often an object is visible. Prototypes are few, so their users are searched each time.
static uint64_t times_seen(const assembly_plan* plan, uint32_t index)
{
    const plan_object* object = &plan->objects[index];
    if (!object->prototype) {
        return object->parent == STP_NONE ? 1 : times_seen(plan, object->parent);
    }
    uint64_t sum = 0;
    for (uint32_t i = index + 1; i < plan->object_count; ++i) {
        sum += plan->objects[i].use == index ? times_seen(plan, i) : 0;
    }
    return sum;
}

static void count_uses(assembly_plan* plan)
{
    for (size_t i = 0; i < plan->mesh_count; ++i) {
        plan->meshes[i].uses = 0;
    }
    uint32_t known = STP_NONE; // neighbours mostly have the same parent
    uint64_t times = 1;
    for (size_t i = 0; i < plan->object_count; ++i) {
        const plan_object* object = &plan->objects[i];
        if (object->mesh == STP_NONE) {
            continue;
        }
        if (object->parent != known) {
            known = object->parent;
            times = times_seen(plan, (uint32_t)i);
        }
        plan->meshes[object->mesh].uses += times;
    }
}

plan_counts plan_count(const assembly_plan* plan)
{
    plan_counts sum = {0};
    for (size_t i = 0; i < plan->mesh_count; ++i) {
        const plan_mesh* mesh = &plan->meshes[i];
        sum.objects += mesh->uses;
        sum.unique_objects += mesh->uses > 0;
        sum.triangles += mesh->uses * mesh->triangles;
        sum.unique_triangles += mesh->uses > 0 ? mesh->triangles : 0;
    }
    return sum;
}

// Below a detail of 1 there are fewer details, with fewer sides; above it only the sides increase.
static void run_recipe(const plan_mesh* mesh, mesh_builder* builder, double detail,
                       uint64_t* vertices, uint64_t* triangles)
{
    shape_ring rings[SHAPE_RINGS];
    for (int i = 0; i < SHAPE_RINGS; ++i) {
        rings[i].sides = 0;
    }
    const double whole = 0.04; // lowest detail at which all shapes are made
    double root = sqrt(detail), fourth = sqrt(root);
    shaper s = {.builder = builder,
                .tessellation = detail < 1.0 ? fourth : root,
                .amount = detail < 1.0 ? root * fourth : 1.0,
                .keep = mesh->sparse && detail < whole ? detail / whole : 1.0,
                .seed = mesh->seed,
                .place = stp_affine_identity(),
                .rings = rings};
    if (builder != NULL) {
        shaper_reserve(&s, mesh->vertices, mesh->triangles);
    }
    mesh->make(&s, mesh->parameters);
    *vertices = s.vertices;
    *triangles = s.triangles;
}

// A mesh_maker of a plan_mesh.
static void make_mesh(mesh_builder* builder, const void* mesh)
{
    const plan_mesh* planned = mesh;
    uint64_t vertices, triangles;
    run_recipe(planned, builder, planned->detail, &vertices, &triangles);
}

typedef struct fit_task {
    assembly_plan* plan;
    double rare_factor, common_factor; // factors on the designed triangles
    double pivot;                      // maximum uses of a rare mesh
    double scale;
} fit_task;

static double factor_of(const fit_task* task, const plan_mesh* mesh)
{
    return (double)mesh->uses > task->pivot ? task->common_factor : task->rare_factor;
}

// Simple parts keep all triangles: half of a wall would be useless.
static double wanted_triangles(const fit_task* task, const plan_mesh* mesh)
{
    const double simple = task->scale < 1.0 ? 240.0 : 2400.0;
    double designed = (double)mesh->designed, wanted = designed * factor_of(task, mesh);
    double least = designed < simple ? designed : simple;
    return wanted < least ? least : wanted;
}

static void count_designed(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const fit_task* task = user;
    for (size_t i = begin; i < end; ++i) {
        plan_mesh* mesh = &task->plan->meshes[i];
        run_recipe(mesh, NULL, 1.0, &mesh->vertices, &mesh->designed);
        mesh->triangles = mesh->designed;
    }
}

// The next detail to try: assumes triangles ~ detail^(4/3), and later bisects the interval.
static double next_detail(double detail, double ratio, double low, double high, int step)
{
    enum { GUESSES = 5 };
    double root = sqrt(ratio), guess = detail * root * sqrt(root);
    bool within = (low <= 0.0 || guess > low) && (high <= 0.0 || guess < high);
    if (low > 0.0 && high > 0.0 && (step > GUESSES || !within)) {
        return sqrt(low * high);
    }
    const double least = 1.0 / 65536.0, most = 64.0;
    guess = within ? guess : low > 0.0 ? 2.0 * low : 0.5 * high;
    return guess < least ? least : guess > most ? most : guess;
}

// Keeps the closest result.
static void fit_mesh(const fit_task* task, plan_mesh* mesh)
{
    enum { STEPS = 14 };
    double wanted = wanted_triangles(task, mesh), detail = mesh->detail, best = -1.0;
    double low = 0.0, high = 0.0; // details with too few and with too many triangles
    for (int k = 0; k < STEPS; ++k) {
        uint64_t vertices, triangles;
        run_recipe(mesh, NULL, detail, &vertices, &triangles);
        double off = (double)triangles - wanted, distance = off < 0.0 ? -off : off;
        if (best < 0.0 || distance < best) {
            best = distance;
            mesh->detail = detail;
            mesh->triangles = triangles;
            mesh->vertices = vertices;
        }
        if (distance < 1e-3 * wanted || triangles == 0) {
            break;
        }
        low = off < 0.0 && detail > low ? detail : low;
        high = off > 0.0 && (high <= 0.0 || detail < high) ? detail : high;
        detail = next_detail(detail, wanted / (double)triangles, low, high, k);
    }
}

static void fit_meshes(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const fit_task* task = user;
    for (size_t i = begin; i < end; ++i) {
        fit_mesh(task, &task->plan->meshes[i]);
    }
}

// Two unknown factors from two sums: unique triangles, and triangles with all uses.
static void solve_factors(fit_task* task, double unique, double total)
{
    double rare[2] = {0, 0}, common[2] = {0, 0};
    for (size_t i = 0; i < task->plan->mesh_count; ++i) {
        const plan_mesh* mesh = &task->plan->meshes[i];
        double* sum = (double)mesh->uses > task->pivot ? common : rare;
        sum[0] += mesh->uses > 0 ? (double)mesh->designed : 0.0;
        sum[1] += (double)(mesh->uses * mesh->designed);
    }
    double determinant = rare[0] * common[1] - common[0] * rare[1];
    if (determinant > 0.0) {
        task->rare_factor = (unique * common[1] - common[0] * total) / determinant;
        task->common_factor = (rare[0] * total - rare[1] * unique) / determinant;
    }
    if (common[0] <= 0.0 && rare[0] > 0.0) { // nothing is used more often than the rest
        task->rare_factor = unique / rare[0];
    }
    const double least = 1e-4; // if a layout cannot reach the wanted totals
    task->rare_factor = task->rare_factor < least ? least : task->rare_factor;
    task->common_factor = task->common_factor < least ? least : task->common_factor;
}

void plan_fit(assembly_plan* plan, const plan_counts* wanted, double scale)
{
    enum { ROUNDS = 14 };
    if (plan->failed) {
        return;
    }
    fit_task task = {plan, scale, scale,
                     plan->common_uses > 0.0
                         ? plan->common_uses
                         : (double)wanted->triangles / (double)wanted->unique_triangles,
                     scale};
    const double sparse_below = 0.125; // larger scales skip no shapes
    for (size_t i = 0; i < plan->mesh_count; ++i) {
        plan->meshes[i].sparse = scale < sparse_below;
    }
    count_uses(plan);
    stp_parallel_for(plan->context, plan->mesh_count, 4, count_designed, &task);
    double unique = (double)wanted->unique_triangles * scale;
    double total = (double)wanted->triangles * scale;
    double unique_aim = unique, total_aim = total;
    for (int round = 0; round < ROUNDS; ++round) {
        solve_factors(&task, unique_aim, total_aim);
        stp_parallel_for(plan->context, plan->mesh_count, 4, fit_meshes, &task);
        plan_counts got = plan_count(plan);
        double unique_off = unique - (double)got.unique_triangles;
        double total_off = total - (double)got.triangles;
        const double near = 6e-4 * 6e-4;
        if (unique_off * unique_off < near * unique * unique &&
            total_off * total_off < near * total * total) {
            break;
        }
        unique_aim += 1.25 * unique_off; // overcorrects, since some shapes cannot follow
        total_aim += 1.25 * total_off;
        if (unique_aim <= 0.0 || total_aim <= 0.0) {
            break; // even the simplest forms of all parts are too many
        }
    }
}

static stp_result add_planned_object(stp_scene* scene, const plan_object* planned, uint32_t top,
                                     uint32_t first, uint32_t first_mesh)
{
    stp_object object = {.name = planned->name,
                         .parent = planned->parent == STP_NONE ? top : first + planned->parent,
                         .transform = planned->transform,
                         .flags = planned->prototype ? STP_OBJECT_PROTOTYPE : 0};
    stp_result result = stp_scene_add_object(scene, &object, NULL);
    if (result == STP_OK && planned->mesh != STP_NONE) {
        result = stp_scene_add_part(scene, (stp_part){STP_PART_MESH, first_mesh + planned->mesh});
    }
    if (result == STP_OK && planned->use != STP_NONE) {
        result = stp_scene_add_use(scene, first + planned->use);
    }
    return result;
}

static stp_result add_meshes(const assembly_plan* plan, stp_scene* scene, uint32_t* first_mesh)
{
    uint32_t first_material = (uint32_t)scene->material_count;
    stp_result result = STP_OK;
    for (int i = 0; result == STP_OK && i < FINISH_COUNT; ++i) {
        stp_material material = plan_material((plan_finish)i);
        result = stp_scene_add_material(scene, &material, NULL);
    }
    mesh_recipe* recipes = STP_NEW_ARRAY(plan->context, mesh_recipe, plan->mesh_count + 1);
    if (result != STP_OK || recipes == NULL) {
        stp_free(plan->context, recipes);
        return result == STP_OK ? stp_fail_memory(plan->context) : result;
    }
    for (size_t i = 0; i < plan->mesh_count; ++i) {
        const plan_mesh* mesh = &plan->meshes[i];
        recipes[i] = (mesh_recipe){mesh->name, make_mesh, mesh, first_material + mesh->material};
    }
    result = make_meshes(scene, recipes, plan->mesh_count, first_mesh);
    stp_free(plan->context, recipes);
    return result;
}

stp_result plan_build(assembly_plan* plan, stp_scene* scene, uint32_t parent, const char* name,
                      const stp_affine* place, uint32_t* object)
{
    if (plan->failed) {
        return stp_fail_memory(plan->context);
    }
    uint32_t first_mesh = 0;
    stp_result result = add_meshes(plan, scene, &first_mesh);
    stp_object top = {.name = name, .parent = parent, .transform = *place};
    uint32_t top_index = 0;
    if (result == STP_OK) {
        result = stp_scene_add_object(scene, &top, &top_index);
    }
    for (size_t i = 0; result == STP_OK && i < plan->object_count; ++i) {
        result = add_planned_object(scene, &plan->objects[i], top_index, top_index + 1, first_mesh);
    }
    if (result == STP_OK && object != NULL) {
        *object = top_index;
    }
    return result;
}
