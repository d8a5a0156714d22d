// SPDX-License-Identifier: MIT
// Dear ImGui's frame, its style, and the layout of panels.
#include "program/viewer/window/gui.h"

#include "program/viewer/window/gui_internal.h"

#include <backends/imgui_impl_opengl3.h>
#include <backends/imgui_impl_sdl.h>
#include <cmath>
#include <imgui_internal.h>

float gui_scale = 1.0f;
SDL_Renderer* gui_software;

namespace
{

void set_style(float scale)
{
    ImGuiStyle& style = ImGui::GetStyle();
    ImGui::StyleColorsDark();
    style.WindowPadding = ImVec2(12, 10);
    style.FramePadding = ImVec2(8, 4);
    style.ItemSpacing = ImVec2(8, 6);
    style.ItemInnerSpacing = ImVec2(6, 4);
    style.IndentSpacing = 14;
    style.ScrollbarSize = 12;
    style.GrabMinSize = 12;
    style.WindowRounding = 0;
    style.FrameRounding = 4;
    style.GrabRounding = 4;
    style.PopupRounding = 4;
    style.ScrollbarRounding = 4;
    style.WindowBorderSize = 0;
    style.ScaleAllSizes(scale);
    ImVec4* c = style.Colors;
    c[ImGuiCol_Text] = ImVec4(0.90f, 0.91f, 0.92f, 1.0f);
    c[ImGuiCol_TextDisabled] = ImVec4(0.60f, 0.63f, 0.66f, 1.0f);
    c[ImGuiCol_WindowBg] = ImVec4(0.125f, 0.135f, 0.15f, 1.0f);
    c[ImGuiCol_PopupBg] = ImVec4(0.16f, 0.17f, 0.19f, 0.98f);
    c[ImGuiCol_ChildBg] = ImVec4(0.10f, 0.11f, 0.12f, 1.0f);
    c[ImGuiCol_FrameBg] = ImVec4(0.21f, 0.225f, 0.245f, 1.0f);
    c[ImGuiCol_FrameBgHovered] = ImVec4(0.26f, 0.28f, 0.30f, 1.0f);
    c[ImGuiCol_FrameBgActive] = ImVec4(0.29f, 0.31f, 0.34f, 1.0f);
    c[ImGuiCol_Button] = ImVec4(0.22f, 0.24f, 0.26f, 1.0f);
    c[ImGuiCol_ButtonHovered] = ImVec4(0.29f, 0.32f, 0.35f, 1.0f);
    c[ImGuiCol_ButtonActive] = gui_mixed(gui_accent, 0.8f);
    c[ImGuiCol_Header] = gui_mixed(gui_accent, 0.45f);
    c[ImGuiCol_HeaderHovered] = ImVec4(0.24f, 0.26f, 0.29f, 1.0f);
    c[ImGuiCol_HeaderActive] = gui_mixed(gui_accent, 0.6f);
    c[ImGuiCol_CheckMark] = gui_accent;
    c[ImGuiCol_SliderGrab] = gui_mixed(gui_accent, 0.85f);
    c[ImGuiCol_SliderGrabActive] = gui_accent;
    c[ImGuiCol_PlotHistogram] = gui_accent;
    c[ImGuiCol_Separator] = ImVec4(0.24f, 0.26f, 0.28f, 1.0f);
    c[ImGuiCol_NavHighlight] = gui_accent;
}

// Draws ImGui's triangles through SDL, on machines without OpenGL.
void draw_with_sdl(const ImDrawData* data)
{
    for (int i = 0; i < data->CmdListsCount; ++i) {
        const ImDrawList* list = data->CmdLists[i];
        for (const ImDrawCmd& command : list->CmdBuffer) {
            ImVec4 r = command.ClipRect;
            SDL_Rect clip = {int(r.x), int(r.y), int(r.z - r.x), int(r.w - r.y)};
            if (clip.w <= 0 || clip.h <= 0) {
                continue;
            }
            SDL_RenderSetClipRect(gui_software, &clip);
            const ImDrawVert* vertices = list->VtxBuffer.Data + command.VtxOffset;
            SDL_RenderGeometryRaw(gui_software, static_cast<SDL_Texture*>(command.GetTexID()),
                                  &vertices->pos.x, int(sizeof(ImDrawVert)),
                                  reinterpret_cast<const SDL_Color*>(&vertices->col),
                                  int(sizeof(ImDrawVert)), &vertices->uv.x, int(sizeof(ImDrawVert)),
                                  list->VtxBuffer.Size - int(command.VtxOffset),
                                  list->IdxBuffer.Data + command.IdxOffset, int(command.ElemCount),
                                  int(sizeof(ImDrawIdx)));
        }
    }
    SDL_RenderSetClipRect(gui_software, nullptr);
}

} // namespace

bool gui_create(SDL_Window* window, void* gl, SDL_Renderer* renderer, float scale)
{
    IMGUI_CHECKVERSION();
    ImGui::CreateContext();
    ImGuiIO& io = ImGui::GetIO();
    io.IniFilename = nullptr;
    gui_scale = scale;
    gui_software = gl != nullptr ? nullptr : renderer;
    set_style(scale);
    bool has_fonts = gui_fonts_create();
    if (gl != nullptr) {
        return has_fonts && ImGui_ImplSDL2_InitForOpenGL(window, gl) &&
               ImGui_ImplOpenGL3_Init("#version 330");
    }
    return ImGui_ImplSDL2_InitForSDLRenderer(window) && has_fonts;
}

void gui_destroy(void)
{
    if (gui_software == nullptr) {
        ImGui_ImplOpenGL3_Shutdown();
    }
    gui_fonts_destroy();
    ImGui_ImplSDL2_Shutdown();
    ImGui::DestroyContext();
}

void gui_take_event(const SDL_Event* event)
{
    ImGui_ImplSDL2_ProcessEvent(event);
    if (event->type == SDL_KEYDOWN || event->type == SDL_KEYUP) {
        // the modifiers at the time of the event: SDL's own state already includes all later events
        ImGuiIO& io = ImGui::GetIO();
        io.KeyShift = (event->key.keysym.mod & KMOD_SHIFT) != 0;
        io.KeyCtrl = (event->key.keysym.mod & KMOD_CTRL) != 0;
        io.KeyAlt = (event->key.keysym.mod & KMOD_ALT) != 0;
    }
}

void gui_begin_frame(int width, int height, float density)
{
    gui_fonts_rebuild();
    if (gui_software == nullptr) {
        ImGui_ImplOpenGL3_NewFrame();
    }
    ImGui_ImplSDL2_NewFrame();
    // the interface uses pixels, even if window units are larger
    ImGuiIO& io = ImGui::GetIO();
    io.DisplaySize = ImVec2(float(width), float(height));
    io.DisplayFramebufferScale = ImVec2(1.0f, 1.0f);
    if (ImGui::IsMousePosValid(&io.MousePos)) {
        // ImGui would query the position on the desktop, which does not change on X11 while a
        // button is down
        int x, y;
        SDL_GetMouseState(&x, &y);
        io.MousePos = ImVec2(float(x) * density, float(y) * density);
    }
    ImGui::NewFrame();
}

void gui_end_frame(void)
{
    ImGui::Render();
    if (gui_software == nullptr) {
        ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
    } else {
        draw_with_sdl(ImGui::GetDrawData());
    }
}

bool gui_wants_mouse(void)
{
    return ImGui::GetIO().WantCaptureMouse;
}

bool gui_wants_keys(void)
{
    return ImGui::GetIO().WantTextInput;
}

bool gui_awaits_tooltip(void)
{
    const ImGuiContext& g = *ImGui::GetCurrentContext();
    return gui_fonts_are_old() || (g.HoveredId != 0 && g.HoveredIdTimer < gui_tooltip_after + 0.1f);
}

float gui_line_height(void)
{
    return ImGui::GetFrameHeight();
}

float gui_text_height(void)
{
    return ImGui::GetTextLineHeight();
}

float gui_gap(void)
{
    return ImGui::GetStyle().ItemSpacing.y;
}

float gui_text_width(const char* text)
{
    return ImGui::CalcTextSize(text).x;
}

static const ImGuiWindowFlags fixed_flags =
    ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoSavedSettings |
    ImGuiWindowFlags_NoNav;

void gui_panel_begin(const char* name, float x, float y, float width, float height)
{
    ImGui::SetNextWindowPos(ImVec2(x, y));
    ImGui::SetNextWindowSize(ImVec2(width, height));
    ImGui::Begin(name, nullptr,
                 (fixed_flags & ~ImGuiWindowFlags_NoScrollbar) |
                     ImGuiWindowFlags_NoBringToFrontOnFocus);
    ImGui::PushItemWidth(-0.42f * width);
}

void gui_bar_begin(const char* name, float x, float y, float width, float height, bool of_text)
{
    float line = of_text ? ImGui::GetTextLineHeight() : ImGui::GetFrameHeight();
    ImGui::SetNextWindowPos(ImVec2(x, y));
    ImGui::SetNextWindowSize(ImVec2(width, height));
    ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding,
                        ImVec2(12.0f * gui_scale, std::floor(0.5f * (height - line))));
    ImGui::PushStyleVar(ImGuiStyleVar_WindowMinSize, ImVec2(1.0f, 1.0f));
    ImGui::Begin(name, nullptr,
                 fixed_flags | ImGuiWindowFlags_NoScrollWithMouse |
                     ImGuiWindowFlags_NoBringToFrontOnFocus);
    ImGui::PopStyleVar(2);
    if (!of_text) {
        ImGui::AlignTextToFramePadding();
    }
    ImGui::PushItemWidth(-1.0f);
}

void gui_panel_end(void)
{
    ImGui::PopItemWidth();
    ImGui::End();
}

void gui_dialog_begin(const char* name, float x, float y, float width)
{
    ImVec2 whole = ImGui::GetIO().DisplaySize;
    const ImGuiWindow* before = ImGui::FindWindowByName(name);
    float height = before != nullptr ? before->Size.y : 0.0f;
    width = width < whole.x ? width : whole.x;
    x = ImClamp(x, 0.5f * width, whole.x - 0.5f * width);
    y = height < whole.y ? ImClamp(y, 0.5f * height, whole.y - 0.5f * height) : 0.5f * whole.y;
    ImGui::SetNextWindowPos(ImVec2(x, y), ImGuiCond_Always, ImVec2(0.5f, 0.5f));
    ImGui::SetNextWindowSize(ImVec2(width, 0.0f)); // as high as needed
    ImGui::SetNextWindowSizeConstraints(ImVec2(1.0f, 1.0f), whole);
    ImGui::PushStyleVar(ImGuiStyleVar_WindowRounding, 8.0f * gui_scale);
    ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, ImVec2(20 * gui_scale, 16 * gui_scale));
    ImGui::PushStyleVar(ImGuiStyleVar_WindowBorderSize, 1.0f);
    ImGui::Begin(name, nullptr, fixed_flags & ~ImGuiWindowFlags_NoScrollbar);
    ImGui::PopStyleVar(3);
    ImGui::PushItemWidth(-0.42f * width);
}

void gui_same_line(void)
{
    ImGui::SameLine();
}

void gui_right_aligned(float width)
{
    float x = ImGui::GetWindowContentRegionMax().x - width;
    ImGui::SameLine(x > 0.0f ? x : 0.0f);
}

void gui_space(void)
{
    ImGui::Dummy(ImVec2(1.0f, 4.0f * gui_scale));
}

void gui_separator(void)
{
    ImGui::Separator();
}

void gui_fill_width(void)
{
    ImGui::SetNextItemWidth(-1.0f);
}

void gui_push_id(int id)
{
    ImGui::PushID(id);
}

void gui_pop_id(void)
{
    ImGui::PopID();
}

void gui_disable(bool disabled)
{
    ImGui::BeginDisabled(disabled);
}

void gui_enable(void)
{
    ImGui::EndDisabled();
}

bool gui_section(const char* label, bool open)
{
    ImGui::PushStyleColor(ImGuiCol_Header, ImVec4(0.17f, 0.185f, 0.205f, 1.0f));
    bool is_open = ImGui::CollapsingHeader(label, open ? ImGuiTreeNodeFlags_DefaultOpen : 0);
    ImGui::PopStyleColor();
    return is_open;
}
