// SPDX-License-Identifier: MIT
#include "gui.h"

extern "C" {
#include "glyphs.h"
}

#include <SDL.h>
#include <backends/imgui_impl_opengl3.h>
#include <backends/imgui_impl_sdl.h>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <cstring>
#include <imgui.h>
#include <imgui_internal.h>

namespace
{

SDL_Renderer* software; // NULL: OpenGL
SDL_Texture* font_texture;
float ui_scale = 1.0f, font_size = 15.0f;
glyph_set further_glyphs;           // beyond those that are always there
bool font_is_old;                   // there are more since it was made
const float tooltip_seconds = 0.5f; // that the mouse rests on something

const ImVec4 accent = {0.30f, 0.62f, 0.82f, 1.0f};

ImVec4 mixed(const ImVec4& color, float alpha)
{
    return ImVec4(color.x, color.y, color.z, alpha);
}

void set_look(float scale)
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
    c[ImGuiCol_ButtonActive] = mixed(accent, 0.8f);
    c[ImGuiCol_Header] = mixed(accent, 0.45f);
    c[ImGuiCol_HeaderHovered] = ImVec4(0.24f, 0.26f, 0.29f, 1.0f);
    c[ImGuiCol_HeaderActive] = mixed(accent, 0.6f);
    c[ImGuiCol_CheckMark] = accent;
    c[ImGuiCol_SliderGrab] = mixed(accent, 0.85f);
    c[ImGuiCol_SliderGrabActive] = accent;
    c[ImGuiCol_PlotHistogram] = accent;
    c[ImGuiCol_Separator] = ImVec4(0.24f, 0.26f, 0.28f, 1.0f);
    c[ImGuiCol_NavHighlight] = accent;
}

// Adds a font's letters to those of the fonts before. @return false where there is no such font
bool add_font(const char* file, const uint16_t* ranges, bool merges)
{
    FILE* found = std::fopen(file, "rb");
    if (found == nullptr) {
        return false;
    }
    std::fclose(found);
    ImFontConfig config;
    config.MergeMode = merges;
    return ImGui::GetIO().Fonts->AddFontFromFileTTF(file, font_size, &config, ranges) != nullptr;
}

// A font of the system with the letters of most European languages, ImGui's own where there is none; and from others what
// names in other scripts need. What none has is shown as a box.
void load_fonts()
{
    static const char* const files[] = {
        "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf",
        "/usr/share/fonts/truetype/noto/NotoSans-Regular.ttf",
        "/usr/share/fonts/truetype/liberation/LiberationSans-Regular.ttf",
    };
    static const char* const others[] = {
        "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf",
        "/usr/share/fonts/opentype/noto/NotoSansCJK-Regular.ttc",
        "/usr/share/fonts/truetype/noto/NotoSansCJK-Regular.ttc",
        "/usr/share/fonts/truetype/droid/DroidSansFallbackFull.ttf",
        "/usr/share/fonts/truetype/droid/DroidSansFallback.ttf",
        "/usr/share/fonts/truetype/wqy/wqy-microhei.ttc",
        "/usr/share/fonts/opentype/unifont/unifont.otf",
        "/usr/share/fonts/truetype/unifont/unifont.ttf",
    };
    ImFontAtlas* atlas = ImGui::GetIO().Fonts;
    atlas->Clear();
    bool loaded = false;
    for (const char* file : files) {
        loaded = loaded || add_font(file, glyphs_always, false);
    }
    if (!loaded) {
        ImFontConfig config;
        config.SizePixels = font_size;
        atlas->AddFontDefault(&config);
    }
    if (further_glyphs.count > 0) {
        const uint16_t* ranges = glyphs_make_ranges(&further_glyphs);
        for (const char* file : others) {
            add_font(file, ranges, true);
        }
    }
    atlas->Fonts[0]->FallbackChar = 0x25A1;
}

bool make_font_texture()
{
    unsigned char* pixels;
    int width, height;
    ImGui::GetIO().Fonts->GetTexDataAsRGBA32(&pixels, &width, &height);
    font_texture = SDL_CreateTexture(software, SDL_PIXELFORMAT_RGBA32, SDL_TEXTUREACCESS_STATIC,
                                     width, height);
    if (font_texture == nullptr) {
        return false;
    }
    SDL_UpdateTexture(font_texture, nullptr, pixels, 4 * width);
    SDL_SetTextureBlendMode(font_texture, SDL_BLENDMODE_BLEND);
    SDL_SetTextureScaleMode(font_texture, SDL_ScaleModeLinear);
    ImGui::GetIO().Fonts->SetTexID(font_texture);
    return true;
}

// Once texts need more letters.
void make_fonts_anew()
{
    if (software == nullptr) {
        ImGui_ImplOpenGL3_DestroyFontsTexture();
        load_fonts();
        ImGui_ImplOpenGL3_CreateFontsTexture();
    } else {
        SDL_DestroyTexture(font_texture);
        load_fonts();
        make_font_texture();
    }
}

// ImGui's triangles through SDL, for machines without OpenGL.
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
            SDL_RenderSetClipRect(software, &clip);
            const ImDrawVert* vertices = list->VtxBuffer.Data + command.VtxOffset;
            SDL_RenderGeometryRaw(software, static_cast<SDL_Texture*>(command.GetTexID()),
                                  &vertices->pos.x, int(sizeof(ImDrawVert)),
                                  reinterpret_cast<const SDL_Color*>(&vertices->col),
                                  int(sizeof(ImDrawVert)), &vertices->uv.x, int(sizeof(ImDrawVert)),
                                  list->VtxBuffer.Size - int(command.VtxOffset),
                                  list->IdxBuffer.Data + command.IdxOffset, int(command.ElemCount),
                                  int(sizeof(ImDrawIdx)));
        }
    }
    SDL_RenderSetClipRect(software, nullptr);
}

// Whatever is shown that others wrote goes through one of these.
void need_letters(const char* text)
{
    font_is_old = glyphs_note(&further_glyphs, text) || font_is_old;
}

void need_letters_of(const char* format, va_list list)
{
    char text[2048];
    va_list copy;
    va_copy(copy, list);
    std::vsnprintf(text, sizeof(text), format, copy);
    va_end(copy);
    need_letters(text);
}

ImU32 color_of(uint32_t c)
{
    return IM_COL32(c >> 24, c >> 16 & 255, c >> 8 & 255, c & 255);
}

} // namespace

bool gui_create(SDL_Window* window, void* gl, SDL_Renderer* renderer, float scale)
{
    IMGUI_CHECKVERSION();
    ImGui::CreateContext();
    ImGuiIO& io = ImGui::GetIO();
    io.IniFilename = nullptr;
    ui_scale = scale;
    software = gl != nullptr ? nullptr : renderer;
    set_look(scale);
    font_size = 15.0f * scale;
    load_fonts();
    if (gl != nullptr) {
        return ImGui_ImplSDL2_InitForOpenGL(window, gl) && ImGui_ImplOpenGL3_Init("#version 330");
    }
    return ImGui_ImplSDL2_InitForSDLRenderer(window) && make_font_texture();
}

void gui_destroy(void)
{
    if (software == nullptr) {
        ImGui_ImplOpenGL3_Shutdown();
    } else {
        SDL_DestroyTexture(font_texture);
    }
    ImGui_ImplSDL2_Shutdown();
    ImGui::DestroyContext();
}

void gui_take_event(const SDL_Event* event)
{
    ImGui_ImplSDL2_ProcessEvent(event);
}

void gui_begin_frame(int width, int height, float density)
{
    if (font_is_old) {
        font_is_old = false;
        make_fonts_anew();
    }
    if (software == nullptr) {
        ImGui_ImplOpenGL3_NewFrame();
    }
    ImGui_ImplSDL2_NewFrame();
    // all that is said here is in pixels, also where the window's units are larger
    ImGuiIO& io = ImGui::GetIO();
    io.DisplaySize = ImVec2(float(width), float(height));
    io.DisplayFramebufferScale = ImVec2(1.0f, 1.0f);
    if (ImGui::IsMousePosValid(&io.MousePos)) {
        io.MousePos = ImVec2(io.MousePos.x * density, io.MousePos.y * density);
    }
    ImGui::NewFrame();
}

void gui_end_frame(void)
{
    ImGui::Render();
    if (software == nullptr) {
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

bool gui_waits(void)
{
    const ImGuiContext& g = *ImGui::GetCurrentContext();
    return font_is_old || (g.HoveredId != 0 && g.HoveredIdTimer < tooltip_seconds + 0.1f);
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
                        ImVec2(12.0f * ui_scale, std::floor(0.5f * (height - line))));
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
    ImGui::PushStyleVar(ImGuiStyleVar_WindowRounding, 8.0f * ui_scale);
    ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, ImVec2(20 * ui_scale, 16 * ui_scale));
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
    ImGui::Dummy(ImVec2(1.0f, 4.0f * ui_scale));
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

void gui_text(const char* format, ...)
{
    va_list list;
    va_start(list, format);
    need_letters_of(format, list);
    ImGui::TextV(format, list);
    va_end(list);
}

void gui_faint(const char* format, ...)
{
    va_list list;
    va_start(list, format);
    need_letters_of(format, list);
    ImGui::TextDisabledV(format, list);
    va_end(list);
}

void gui_faint_paragraph(const char* format, ...)
{
    ImGui::PushStyleColor(ImGuiCol_Text, ImGui::GetStyleColorVec4(ImGuiCol_TextDisabled));
    va_list list;
    va_start(list, format);
    need_letters_of(format, list);
    ImGui::TextWrappedV(format, list);
    va_end(list);
    ImGui::PopStyleColor();
}

void gui_paragraph(const char* format, ...)
{
    va_list list;
    va_start(list, format);
    need_letters_of(format, list);
    ImGui::TextWrappedV(format, list);
    va_end(list);
}

void gui_value(const char* name, const char* format, ...)
{
    ImGui::TextDisabled("%s", name);
    ImGui::SameLine(0.42f * ImGui::GetWindowWidth());
    ImGui::PushTextWrapPos(0.0f);
    va_list list;
    va_start(list, format);
    need_letters_of(format, list);
    ImGui::TextV(format, list);
    va_end(list);
    ImGui::PopTextWrapPos();
}

void gui_tooltip(const char* text)
{
    if (text != nullptr && ImGui::IsItemHovered(ImGuiHoveredFlags_AllowWhenDisabled) &&
        (ImGui::GetCurrentContext()->HoveredId == 0 ||
         ImGui::GetCurrentContext()->HoveredIdTimer >= tooltip_seconds) &&
        !ImGui::IsAnyMouseDown()) {
        ImGui::BeginTooltip();
        ImGui::PushTextWrapPos(320.0f * ui_scale);
        ImGui::TextUnformatted(text);
        ImGui::PopTextWrapPos();
        ImGui::EndTooltip();
    }
}

bool gui_button(const char* label, const char* tooltip)
{
    bool pressed = ImGui::Button(label);
    gui_tooltip(tooltip);
    return pressed;
}

bool gui_wide_button(const char* label, int share, const char* tooltip)
{
    const ImGuiStyle& style = ImGui::GetStyle();
    float whole = ImGui::GetWindowContentRegionMax().x - ImGui::GetWindowContentRegionMin().x;
    float width = (whole - float(share - 1) * style.ItemSpacing.x) / float(share);
    bool pressed = ImGui::Button(label, ImVec2(width, 0.0f));
    gui_tooltip(tooltip);
    return pressed;
}

bool gui_toggle(const char* label, bool on, const char* tooltip)
{
    if (on) {
        ImGui::PushStyleColor(ImGuiCol_Button, mixed(accent, 0.55f));
        ImGui::PushStyleColor(ImGuiCol_ButtonHovered, mixed(accent, 0.7f));
    }
    bool pressed = gui_button(label, tooltip);
    if (on) {
        ImGui::PopStyleColor(2);
    }
    return pressed;
}

bool gui_name_toggle(const char* name, bool on, float beside, const char* tooltip)
{
    need_letters(name);
    const ImGuiStyle& style = ImGui::GetStyle();
    ImVec2 size = ImGui::CalcTextSize(name);
    float wanted = size.x + 2.0f * style.FramePadding.x;
    float room = ImGui::GetContentRegionAvail().x - beside;
    float least = ImGui::GetFrameHeight();
    bool fits = wanted <= room;
    float width = fits ? wanted : room > least ? room : least;
    ImVec2 start = ImGui::GetCursorScreenPos();
    if (on) {
        ImGui::PushStyleColor(ImGuiCol_Button, mixed(accent, 0.55f));
        ImGui::PushStyleColor(ImGuiCol_ButtonHovered, mixed(accent, 0.7f));
    }
    bool pressed = ImGui::Button("##name", ImVec2(width, 0.0f));
    if (on) {
        ImGui::PopStyleColor(2);
    }
    gui_tooltip(fits ? tooltip : name);
    ImVec2 text = ImVec2(start.x + style.FramePadding.x, start.y + style.FramePadding.y);
    ImVec2 end = ImVec2(start.x + width - style.FramePadding.x, text.y + size.y);
    ImDrawList* list = ImGui::GetWindowDrawList();
    list->PushClipRect(text, end, true);
    list->AddText(text, ImGui::GetColorU32(ImGuiCol_Text), name);
    list->PopClipRect();
    return pressed;
}

bool gui_check(const char* label, bool* value, const char* tooltip)
{
    bool changed = ImGui::Checkbox(label, value);
    gui_tooltip(tooltip);
    return changed;
}

bool gui_slider(const char* label, float* value, float least, float most, const char* format,
                const char* tooltip)
{
    bool changed =
        ImGui::SliderFloat(label, value, least, most, format, ImGuiSliderFlags_AlwaysClamp);
    gui_tooltip(tooltip);
    return changed;
}

bool gui_log_slider(const char* label, float* value, float least, float most, const char* format,
                    const char* tooltip)
{
    bool changed = ImGui::SliderFloat(label, value, least, most, format,
                                      ImGuiSliderFlags_AlwaysClamp | ImGuiSliderFlags_Logarithmic);
    gui_tooltip(tooltip);
    return changed;
}

bool gui_number(const char* label, double* value, double step, const char* format,
                const char* tooltip)
{
    bool changed = ImGui::DragScalar(label, ImGuiDataType_Double, value, float(step), nullptr,
                                     nullptr, format);
    gui_tooltip(tooltip);
    return changed;
}

bool gui_whole_number(const char* label, int* value, int least, int most, const char* tooltip)
{
    bool changed = ImGui::InputInt(label, value);
    *value = *value < least ? least : *value > most ? most : *value;
    gui_tooltip(tooltip);
    return changed;
}

bool gui_choice(const char* label, int* value, const char* const* words, int count,
                const char* tooltip)
{
    bool changed = ImGui::Combo(label, value, words, count);
    gui_tooltip(tooltip);
    return changed;
}

bool gui_color(const char* label, float color[3], const char* tooltip)
{
    bool changed = ImGui::ColorEdit3(label, color, ImGuiColorEditFlags_NoInputs);
    gui_tooltip(tooltip);
    return changed;
}

bool gui_input(const char* label, const char* hint, char* text, size_t size, bool* entered)
{
    need_letters(text);
    char* before = static_cast<char*>(ImGui::MemAlloc(size));
    std::memcpy(before, text, size);
    bool done =
        ImGui::InputTextWithHint(label, hint, text, size, ImGuiInputTextFlags_EnterReturnsTrue);
    bool changed = std::strncmp(before, text, size) != 0;
    ImGui::MemFree(before);
    if (entered != nullptr) {
        *entered = done;
    }
    return changed;
}

void gui_focus_next(void)
{
    ImGui::SetKeyboardFocusHere();
}

static float row_height()
{
    return ImGui::GetFrameHeight() - 4.0f * ui_scale;
}

int gui_tree_row(const gui_row* row)
{
    int result = 0;
    need_letters(row->label);
    float line = ImGui::GetFrameHeight() - 4.0f * ui_scale;
    ImVec2 start = ImGui::GetCursorScreenPos();
    float width = ImGui::GetContentRegionAvail().x;
    bool pressed = ImGui::InvisibleButton("row", ImVec2(width > 1.0f ? width : 1.0f, line));
    bool hovered = ImGui::IsItemHovered();
    ImDrawList* list = ImGui::GetWindowDrawList();
    ImVec2 end = ImVec2(start.x + width, start.y + line);
    if (row->selected || hovered) {
        list->AddRectFilled(
            start, end,
            ImGui::GetColorU32(row->selected ? ImGuiCol_Header : ImGuiCol_HeaderHovered),
            3.0f * ui_scale);
    }
    float indent = (4.0f + 13.0f * float(row->depth < 12 ? row->depth : 12)) * ui_scale;
    float fold_end = start.x + indent + 14.0f * ui_scale, eye_begin = end.x - 22.0f * ui_scale;
    float middle = start.y + 0.5f * line;
    ImU32 faint = ImGui::GetColorU32(ImGuiCol_TextDisabled);
    if (row->has_children) {
        float x = start.x + indent + 5.0f * ui_scale, s = 3.5f * ui_scale;
        if (row->open) {
            list->AddTriangleFilled(ImVec2(x - s, middle - 0.6f * s),
                                    ImVec2(x + s, middle - 0.6f * s), ImVec2(x, middle + s), faint);
        } else {
            list->AddTriangleFilled(ImVec2(x - 0.6f * s, middle - s), ImVec2(x + s, middle),
                                    ImVec2(x - 0.6f * s, middle + s), faint);
        }
    }
    list->PushClipRect(start, ImVec2(eye_begin, end.y), true);
    list->AddText(
        ImVec2(fold_end, middle - 0.5f * ImGui::GetTextLineHeight()),
        ImGui::GetColorU32(row->faint || !row->shown ? ImGuiCol_TextDisabled : ImGuiCol_Text),
        row->label);
    list->PopClipRect();
    if (hovered || !row->shown) { // the eye
        float x = end.x - 11.0f * ui_scale, r = 4.0f * ui_scale;
        if (row->shown) {
            list->AddCircleFilled(ImVec2(x, middle), r, faint);
        } else {
            list->AddCircle(ImVec2(x, middle), r, faint, 0, 1.5f * ui_scale);
        }
    }
    float at = ImGui::GetIO().MousePos.x;
    if (hovered && at > eye_begin) {
        ImGui::SetTooltip(row->shown ? "Hide" : "Show");
    } else if (hovered && fold_end + ImGui::CalcTextSize(row->label).x > eye_begin) {
        ImGui::SetTooltip("%s", row->label);
    }
    if (hovered && ImGui::IsMouseDoubleClicked(0) && at >= fold_end && at <= eye_begin) {
        result |= GUI_ROW_DOUBLE;
    }
    if (pressed) {
        result |= at > eye_begin                       ? GUI_ROW_SWITCHED
                  : row->has_children && at < fold_end ? GUI_ROW_OPENED
                                                       : GUI_ROW_CLICKED;
    }
    return result;
}

void gui_rows_begin(int count, int* first, int* last)
{
    ImGui::PushStyleVar(ImGuiStyleVar_ItemSpacing, ImVec2(0.0f, 0.0f));
    ImGui::CalcListClipping(count, row_height(), first, last);
    ImGui::Dummy(ImVec2(1.0f, float(*first) * row_height()));
}

void gui_rows_end(int count, int last)
{
    ImGui::Dummy(ImVec2(1.0f, float(count - last) * row_height()));
    ImGui::PopStyleVar();
}

void gui_list_begin(const char* name, float height)
{
    ImGui::PushStyleVar(ImGuiStyleVar_ChildRounding, 4.0f * ui_scale);
    ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, ImVec2(4.0f * ui_scale, 4.0f * ui_scale));
    ImGui::BeginChild(name, ImVec2(0.0f, height), false,
                      ImGuiWindowFlags_AlwaysUseWindowPadding | ImGuiWindowFlags_NoNav);
    ImGui::PopStyleVar(2);
}

void gui_list_end(void)
{
    ImGui::EndChild();
}

void gui_scroll_to_row(int row)
{
    float middle = (float(row) + 0.5f) * row_height() - 0.4f * ImGui::GetWindowHeight();
    ImGui::SetScrollY(middle > 0.0f ? middle : 0.0f);
}

void gui_progress(float fraction, const char* text)
{
    ImGui::ProgressBar(fraction, ImVec2(-1.0f, 0.0f), text);
}

void gui_graph(const float* values, int count, int newest, float most, float mark, float height,
               const char* tooltip)
{
    ImVec2 start = ImGui::GetCursorScreenPos();
    float width = ImGui::GetContentRegionAvail().x;
    ImGui::Dummy(ImVec2(width, height));
    gui_tooltip(tooltip);
    ImDrawList* list = ImGui::GetWindowDrawList();
    ImVec2 end = ImVec2(start.x + width, start.y + height);
    list->AddRectFilled(start, end, ImGui::GetColorU32(ImGuiCol_ChildBg), 4.0f * ui_scale);
    float step = width / float(count);
    for (int i = 0; i < count; ++i) {
        float value = values[(newest + 1 + i) % count];
        float part = value < most ? value / most : 1.0f;
        if (part > 0.0f) {
            bool over = mark > 0.0f && value > 1.1f * mark;
            list->AddRectFilled(ImVec2(start.x + float(i) * step, end.y - part * height),
                                ImVec2(start.x + float(i + 1) * step - 1.0f, end.y),
                                over ? IM_COL32(220, 150, 70, 255)
                                     : ImGui::GetColorU32(mixed(accent, 0.85f)));
        }
    }
    if (mark > 0.0f && mark < most) {
        float y = end.y - mark / most * height;
        list->AddLine(ImVec2(start.x, y), ImVec2(end.x, y), IM_COL32(255, 255, 255, 110));
    }
}

void gui_picture(void* texture, float x0, float y0, float x1, float y1)
{
    ImGui::GetBackgroundDrawList()->AddImage(texture, ImVec2(x0, y0), ImVec2(x1, y1));
}

void gui_clip(float x0, float y0, float x1, float y1)
{
    ImGui::GetBackgroundDrawList()->PushClipRect(ImVec2(x0, y0), ImVec2(x1, y1));
}

void gui_unclip(void)
{
    ImGui::GetBackgroundDrawList()->PopClipRect();
}

void gui_line(float x0, float y0, float x1, float y1, uint32_t color, float width)
{
    ImGui::GetBackgroundDrawList()->AddLine(ImVec2(x0, y0), ImVec2(x1, y1), color_of(color),
                                            width * ui_scale);
}

void gui_disc(float x, float y, float radius, uint32_t fill, uint32_t rim)
{
    ImDrawList* list = ImGui::GetBackgroundDrawList();
    list->AddCircleFilled(ImVec2(x, y), radius * ui_scale, color_of(fill));
    list->AddCircle(ImVec2(x, y), radius * ui_scale, color_of(rim), 0, 1.5f * ui_scale);
}

void gui_box(float x0, float y0, float x1, float y1, uint32_t fill, uint32_t rim)
{
    ImDrawList* list = ImGui::GetBackgroundDrawList();
    list->AddRectFilled(ImVec2(x0, y0), ImVec2(x1, y1), color_of(fill), 6.0f * ui_scale);
    list->AddRect(ImVec2(x0, y0), ImVec2(x1, y1), color_of(rim), 6.0f * ui_scale);
}

static float show_plate(float x, float y, float share, float widest, const char* text,
                        uint32_t color)
{
    need_letters(text);
    float line = ImGui::GetTextLineHeight();
    ImVec2 size = ImGui::CalcTextSize(text, nullptr, false, widest);
    // further lines go up, away from what the plate is about
    ImVec2 start = ImVec2(std::floor(x - share * size.x), std::floor(y + 0.5f * line - size.y));
    ImVec2 pad = ImVec2(6.0f * ui_scale, 3.0f * ui_scale);
    ImDrawList* list = ImGui::GetBackgroundDrawList();
    list->AddRectFilled(ImVec2(start.x - pad.x, start.y - pad.y),
                        ImVec2(start.x + size.x + pad.x, start.y + size.y + pad.y),
                        IM_COL32(24, 26, 29, 225), 4.0f * ui_scale);
    list->AddText(ImGui::GetFont(), ImGui::GetFontSize(), start, color_of(color), text, nullptr,
                  widest);
    return size.y - line;
}

void gui_plate(float x, float y, const char* text, uint32_t color)
{
    show_plate(x, y, 0.5f, 300.0f * ui_scale, text, color);
}

float gui_plate_at(float x, float y, float room, const char* text, uint32_t color)
{
    return show_plate(x, y, 0.0f, room > 1.0f ? room : 1.0f, text, color);
}
