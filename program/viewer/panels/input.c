// SPDX-License-Identifier: MIT
// Input: mouse, keys, gamepad and SpaceMouse control the camera and trigger commands.
#include "program/viewer/model/gamepad.h"
#include "program/viewer/panels/panels.h"
#include "program/viewer/window/gui.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>

static const float click_reach = 4.0f; // pixels of movement that still count as a click
static const double zoom_step = 0.85;  // per notch of the wheel
static const double faster = 5.0;      // with Shift
static const double turn_per_picture =
    STP_PI / 3.0;                     // rotation for a drag over the picture's height
static const double stick_turn = 1.8; // radians per second

static float in_picture_x(const viewer* v, float x)
{
    return x - v->picture_area.x;
}

static float in_picture_y(const viewer* v, float y)
{
    return y - v->picture_area.y;
}

/// The point under the cursor; if there is none, a point at the distance of the visible content.
static stp_vec3d point_under(const viewer* v, float x, float y)
{
    stp_vec3d point;
    return camera_seen(v, x, y, &point)
               ? point
               : stp_navigator_point(&v->camera, (double)in_picture_x(v, x),
                                     (double)in_picture_y(v, y), v->camera.reach);
}

static void begin_drag(viewer* v)
{
    input_state* in = &v->input;
    SDL_Keymod keys = SDL_GetModState();
    bool shift = (keys & KMOD_SHIFT) != 0;
    assert(in->button != 0 && in->drag == DRAG_NONE && "a drag begins once");
    stp_vec3d point;
    bool seen = camera_seen(v, in->start_x, in->start_y, &point);
    v->glide_start = -1.0;
    if (in->button == SDL_BUTTON_RIGHT) {
        in->drag = DRAG_LOOK;
    } else if (in->button == SDL_BUTTON_MIDDLE || shift) {
        double x, y, depth;
        in->drag = DRAG_PAN;
        point = point_under(v, in->start_x, in->start_y);
        in->pan_depth =
            stp_navigator_project(&v->camera, point, &x, &y, &depth) ? depth : v->camera.reach;
    } else {
        in->drag = DRAG_ORBIT;
        stp_navigator_begin_orbit(&v->camera, seen ? &point : NULL);
    }
}

static void drag_on(viewer* v, float x, float y)
{
    input_state* in = &v->input;
    double dx = (double)(x - in->last_x), dy = (double)(y - in->last_y);
    in->last_x = x;
    in->last_y = y;
    if (in->drag == DRAG_ORBIT) {
        stp_navigator_orbit(&v->camera, dx, dy);
    } else if (in->drag == DRAG_PAN) {
        stp_navigator_pan(&v->camera, dx, dy, in->pan_depth);
    } else if (in->drag == DRAG_PARTS) {
        panels_drag_edge(v, x);
    } else if (in->drag == DRAG_SECTION) {
        section_drag(v, x - (float)dx, y - (float)dy, x, y);
    } else if (in->drag == DRAG_LOOK) {
        double angle = turn_per_picture / (double)v->camera.height;
        stp_navigator_turn(&v->camera, dx * angle, dy * angle);
    }
}

static bool is_on_picture(const viewer* v, float x, float y)
{
    viewer_area a = v->picture_area;
    return x >= a.x && y >= a.y && x < a.x + a.width && y < a.y + a.height && !gui_wants_mouse();
}

/// Picks the original content of the shown picture. @return false if that is of another scene
static bool pick_under(viewer* v, float x, float y, stp_pick* pick)
{
    viewer_area a = v->picture_area;
    bool of_scene = v->picture != NULL && v->scene != NULL &&
                    v->picture->scene == v->scene->serial && v->explorer != NULL;
    *pick = (stp_pick){0};
    if (of_scene) {
        const stp_view* view = &v->picture->view;
        (void)explorer_pick(v->explorer, view, v->settings.drawing.style.back_faces,
                            (double)((x - a.x) / a.width) * (double)view->width,
                            (double)((y - a.y) / a.height) * (double)view->height, pick);
    }
    return of_scene;
}

/// Copies the coordinates under the cursor: of the original content, or else of the picture.
static void copy_place(viewer* v)
{
    int ux, uy;
    stp_vec3d seen;
    stp_pick pick;
    SDL_GetMouseState(&ux, &uy);
    float x = (float)ux * v->window.density, y = (float)uy * v->window.density;
    bool sees = is_on_picture(v, x, y) && camera_seen(v, x, y, &seen);
    if (sees) {
        (void)pick_under(v, x, y, &pick);
        measure_copy(v, pick.hit ? pick.position : seen);
    } else {
        viewer_show_message(v, false, "Nothing to copy: no surface is under the cursor");
    }
}

static void click(viewer* v, float x, float y)
{
    stp_vec3d seen;
    stp_pick pick;
    bool sees = camera_seen(v, x, y, &seen);
    bool of_scene = pick_under(v, x, y, &pick);
    if (v->measure.on) {
        measure_click(v, pick.hit ? &pick : NULL, sees ? &seen : NULL);
        return;
    }
    if (of_scene) {
        explorer_choose_picked(v->explorer, pick.hit ? &pick : NULL);
    }
    if (pick.hit) {
        v->picked = pick;
        v->has_picked = true;
    }
    if (pick.hit || sees) {
        stp_navigator_choose_pivot(&v->camera, pick.hit ? pick.position : seen);
        if (v->glide_start >= 0.0) { // it stays when the glide ends
            stp_navigator_choose_pivot(&v->glide_to, pick.hit ? pick.position : seen);
        }
    }
}

static void turn_wheel(viewer* v, double notches)
{
    if (v->input.flies || v->input.drag == DRAG_LOOK) {
        stp_navigator_change_speed(&v->camera, notches);
        return;
    }
    int ux, uy;
    SDL_GetMouseState(&ux, &uy);
    float x = (float)ux * v->window.density, y = (float)uy * v->window.density;
    if (v->scene != NULL && is_on_picture(v, x, y)) {
        v->glide_start = -1.0;
        stp_navigator_zoom(&v->camera, point_under(v, x, y), pow(zoom_step, notches));
    }
}

static void take_mouse(viewer* v, const SDL_Event* e)
{
    input_state* in = &v->input;
    float density = v->window.density;
    if (e->type == SDL_MOUSEBUTTONDOWN) {
        float x = (float)e->button.x * density, y = (float)e->button.y * density;
        bool is_edge = e->button.button == SDL_BUTTON_LEFT && panels_edge(v, x, y);
        if (in->button == 0 && e->button.button == SDL_BUTTON_LEFT && is_on_picture(v, x, y) &&
            !is_edge && orientation_click(v, x, y)) {
            return;
        }
        if (in->button == 0 && (is_edge || (v->scene != NULL && is_on_picture(v, x, y)))) {
            bool grabs = !is_edge && e->button.button == SDL_BUTTON_LEFT && section_grab(v, x, y);
            in->button = e->button.button;
            in->start_x = in->last_x = x;
            in->start_y = in->last_y = y;
            in->moved = grabs || is_edge;
            in->drag = is_edge ? DRAG_PARTS : grabs ? DRAG_SECTION : DRAG_NONE;
            SDL_CaptureMouse(SDL_TRUE);
        }
    } else if (e->type == SDL_MOUSEMOTION && in->button != 0) {
        float x = (float)e->motion.x * density, y = (float)e->motion.y * density;
        float away = hypotf(x - in->start_x, y - in->start_y);
        if (!in->moved && away > click_reach * v->window.scale) {
            in->moved = true;
            begin_drag(v);
        }
        if (in->moved) {
            drag_on(v, x, y);
        }
    } else if (e->type == SDL_MOUSEBUTTONUP && e->button.button == in->button) {
        if (!in->moved && in->button == SDL_BUTTON_LEFT) {
            click(v, in->start_x, in->start_y);
        }
        in->button = 0;
        in->drag = DRAG_NONE;
        SDL_CaptureMouse(SDL_FALSE);
    } else if (e->type == SDL_MOUSEWHEEL) {
        turn_wheel(v, (double)e->wheel.preciseY);
    }
}

static void toggle_page(viewer* v, viewer_page page)
{
    v->settings.page = v->settings.page == page ? PAGE_NONE : page;
    v->shows_panels = true;
}

static bool take_view_key(viewer* v, SDL_Keycode key)
{
    static const struct {
        SDL_Keycode key, pad;
        const char* view;
    } views[] = {
        {SDLK_1, SDLK_KP_1, "front"},
        {SDLK_3, SDLK_KP_3, "right"},
        {SDLK_7, SDLK_KP_7, "top"},
        {SDLK_9, SDLK_KP_9, "iso"},
    };
    for (size_t i = 0; i < sizeof(views) / sizeof(views[0]); ++i) {
        if (key == views[i].key || key == views[i].pad) {
            camera_face(v, views[i].view);
            return true;
        }
    }
    return false;
}

static void switch_fullscreen(viewer* v)
{
    bool full = (SDL_GetWindowFlags(v->window.handle) & SDL_WINDOW_FULLSCREEN_DESKTOP) != 0;
    SDL_SetWindowFullscreen(v->window.handle, full ? 0 : SDL_WINDOW_FULLSCREEN_DESKTOP);
}

/// Switches to the next method of the file.
static void show_next_method(viewer* v)
{
    const stp_store_directory* d = v->scene != NULL ? v->scene->directory : NULL;
    if (d == NULL || stp_store_offered_methods(d) < 2) {
        viewer_show_message(v, false, "This file has splats of only one method");
        return;
    }
    uint32_t place = stp_store_find_method(d, v->settings.drawing.quality.method);
    if (viewer_mixes_methods(v) && place == 0 && v->settings.drawing.quality.method != 0) {
        v->settings.drawing.quality.method = 0; // after the last method, back to automatic
        viewer_show_message(v, false, "Splats by %s, and by others where few suffice",
                            d->methods[0].name);
        return;
    }
    uint32_t next = (place + 1) % stp_store_offered_methods(d);
    v->settings.drawing.quality.method = d->methods[next].id;
    viewer_show_message(v, false, "Splats by %s", d->methods[next].name);
}

/// Keys of panels and tools. @return whether it handled the key
static bool take_tool_key(viewer* v, SDL_Keycode key)
{
    switch (key) {
    case SDLK_F2:
        toggle_page(v, PAGE_QUALITY);
        break;
    case SDLK_F3:
        toggle_page(v, PAGE_SECTION);
        break;
    case SDLK_F4:
        toggle_page(v, PAGE_MEASURE);
        break;
    case SDLK_F5:
        toggle_page(v, PAGE_VIEWS);
        break;
    case SDLK_F6:
        toggle_page(v, PAGE_STATISTICS);
        break;
    case SDLK_k:
        v->section.has_box = !v->section.has_box;
        viewer_show_message(v, false,
                            v->section.has_box ? "Section box on: its handles are in Section (F3)"
                                               : "Section box off");
        break;
    case SDLK_m:
        v->measure.on = !v->measure.on;
        if (v->measure.on) {
            v->settings.page = PAGE_MEASURE;
        }
        break;
    case SDLK_BACKSPACE:
        measure_undo(v);
        break;
    case SDLK_v:
        views_save(v);
        break;
    case SDLK_r:
        record_switch(v);
        break;
    case SDLK_b:
        v->settings.backend = viewer_uses_gl(v) ? BACKEND_PROCESSOR : BACKEND_OPENGL;
        if (!v->window.has_worker) {
            viewer_show_message(v, false, "OpenGL 4.5 is not available");
        }
        break;
    case SDLK_n:
        show_next_method(v);
        break;
    case SDLK_c:
        splats_switch(v);
        break;
    case SDLK_F12:
        shot_begin(v);
        break;
    default:
        return false;
    }
    return true;
}

static void take_key(viewer* v, SDL_Keycode key, bool control)
{
    if (control) {
        v->quits = v->quits || key == SDLK_q;
        if (key == SDLK_o) {
            start_show_dialog(v, true);
        } else if (key >= SDLK_1 && key <= SDLK_9) {
            (void)start_open_recent(v, (size_t)(key - SDLK_1));
        }
        if (key == SDLK_c && !gui_wants_keys()) {
            copy_place(v);
        }
        if (key == SDLK_f) {
            v->settings.parts = false;
            panels_switch_parts(v);
            v->finds = true;
        }
        return;
    }
    if (take_view_key(v, key) || parts_take_key(v, key) || take_tool_key(v, key)) {
        return;
    }
    switch (key) {
    case SDLK_5:
    case SDLK_KP_5:
        camera_switch_projection(v);
        break;
    case SDLK_HOME:
        if (v->explorer != NULL) {
            explorer_choose(v->explorer, NULL, false);
        }
        camera_frame(v, false);
        break;
    case SDLK_f:
        camera_frame(v, false);
        break;
    case SDLK_h:
        v->shows_help = !v->shows_help;
        break;
    case SDLK_ESCAPE:
        if (v->shows_help) {
            v->shows_help = false;
        } else if (v->scene != NULL && messages_put_away(v)) {
            break; // already handled
        } else if (v->measure.on) {
            v->measure.on = false;
        } else if (v->explorer != NULL) {
            explorer_choose(v->explorer, NULL, false);
        }
        break;
    case SDLK_TAB:
        v->shows_panels = !v->shows_panels;
        break;
    case SDLK_p:
        panels_switch_parts(v);
        break;
    case SDLK_F11:
        switch_fullscreen(v);
        break;
    default:
        break;
    }
}

static void take_button(viewer* v, Uint8 button)
{
    if (button == SDL_CONTROLLER_BUTTON_A) {
        camera_frame(v, false);
    } else if (button == SDL_CONTROLLER_BUTTON_DPAD_UP) {
        stp_navigator_change_speed(&v->camera, 1.0);
    } else if (button == SDL_CONTROLLER_BUTTON_DPAD_DOWN) {
        stp_navigator_change_speed(&v->camera, -1.0);
    }
}

void input_take(viewer* v, const SDL_Event* e)
{
    bool control = e->type == SDL_KEYDOWN && (e->key.keysym.mod & KMOD_CTRL) != 0;
    if (e->type == SDL_KEYDOWN && e->key.keysym.sym == SDLK_ESCAPE && start_has_dialog(v)) {
        start_show_dialog(v, false);
    } else if (e->type == SDL_KEYDOWN && !control && !gui_wants_keys() &&
               splats_take_key(v, e->key.keysym.sym, (e->key.keysym.mod & KMOD_SHIFT) != 0)) {
        return; // also while the key repeats
    } else if (e->type == SDL_KEYDOWN && e->key.repeat == 0 && (control || !gui_wants_keys())) {
        take_key(v, e->key.keysym.sym, control);
    } else if (e->type == SDL_CONTROLLERBUTTONDOWN) {
        take_button(v, e->cbutton.button);
    } else if (!gamepad_take(&v->input.pad, e)) {
        take_mouse(v, e);
    }
}

static bool step_pad(viewer* v, double moves[3], double seconds)
{
    gamepad_sticks sticks = gamepad_read(v->input.pad);
    bool turns = sticks.turn != 0.0 || sticks.nod != 0.0;
    for (int i = 0; i < 3; ++i) {
        moves[i] += sticks.moves[i];
    }
    if (turns) {
        v->glide_start = -1.0;
        stp_navigator_turn(&v->camera, sticks.turn * stick_turn * seconds,
                           sticks.nod * stick_turn * seconds);
    }
    return turns;
}

void input_step(viewer* v, double seconds)
{
    const Uint8* held = SDL_GetKeyboardState(NULL);
    SDL_Keymod mods = SDL_GetModState();
    double moves[3] = {0};
    if (!gui_wants_keys() && (mods & (KMOD_CTRL | KMOD_ALT)) == 0) {
        moves[0] = (double)(held[SDL_SCANCODE_D] - held[SDL_SCANCODE_A]);
        moves[1] = (double)(held[SDL_SCANCODE_E] - held[SDL_SCANCODE_Q]);
        moves[2] = (double)(held[SDL_SCANCODE_W] - held[SDL_SCANCODE_S]);
    }
    bool turns = step_pad(v, moves, seconds);
    bool by_space_mouse = space_mouse_step(v, seconds);
    bool by_keys = moves[0] != 0.0 || moves[1] != 0.0 || moves[2] != 0.0;
    if (by_keys && v->has_camera) {
        v->glide_start = -1.0;
        stp_navigator_fly(&v->camera, moves, seconds, (mods & KMOD_SHIFT) != 0 ? faster : 1.0);
    }
    bool flies = ((by_keys || turns) && v->has_camera) || by_space_mouse;
    if (flies != v->input.flies) {
        viewer_redraw(v);
    }
    v->input.flies = flies;
}

bool input_moves(const viewer* v)
{
    return v->input.flies || v->input.pushed;
}

void input_begin(viewer* v)
{
    gamepad_begin();
    v->input.space_mouse = space_mouse_open(viewer_wake, v);
}

void input_destroy(viewer* v)
{
    gamepad_end(&v->input.pad);
    space_mouse_close(v->input.space_mouse);
}
