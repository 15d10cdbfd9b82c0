// Which view a vertex belongs to: from the hardware, or from the pass where each view has a pass of its own.
#ifdef MULTIVIEW
#define VIEW_INDEX gl_ViewIndex
#else
layout(push_constant, scalar) uniform ViewPush {
    uint view;
} view_push;
#define VIEW_INDEX view_push.view
#endif
