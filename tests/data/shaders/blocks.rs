    /// `Everything`, 624 bytes, as `every_type.comp` has it.
    #[repr(C)]
    #[derive(Clone, Copy, Debug, PartialEq, ::bytemuck::Pod, ::bytemuck::Zeroable)]
    pub struct Everything {
        /// `float` at byte 0.
        pub f: f32,
        /// `vec2` at byte 4.
        pub v2: ::glam::Vec2,
        /// `vec3` at byte 12.
        pub v3: ::glam::Vec3,
        /// `vec4` at byte 24.
        pub v4: [f32; 4],
        /// `int` at byte 40.
        pub i: i32,
        /// `ivec2` at byte 44.
        pub i2: [i32; 2],
        /// `ivec3` at byte 52.
        pub i3: [i32; 3],
        /// `ivec4` at byte 64.
        pub i4: [i32; 4],
        /// `uint` at byte 80.
        pub u: u32,
        /// `uvec2` at byte 84.
        pub u2: [u32; 2],
        /// `uvec3` at byte 92.
        pub u3: [u32; 3],
        /// `uvec4` at byte 104.
        pub u4: [u32; 4],
        /// `uint` at byte 120.
        pub b: u32,
        /// `mat2` at byte 124.
        pub m2: [[f32; 2]; 2],
        /// `mat3` at byte 140.
        pub m3: [[f32; 3]; 3],
        /// `mat4` at byte 176.
        pub m4: [[f32; 4]; 4],
        /// `mat3x4` at byte 240.
        pub m34: [[f32; 4]; 3],
        /// `mat4x3` at byte 288.
        pub m43: [[f32; 3]; 4],
        /// `float[5]` at byte 336.
        pub floats: [f32; 5],
        /// `vec3[2][3]` at byte 356.
        pub grid: [[::glam::Vec3; 3]; 2],
        /// `Light` at byte 428.
        pub light: Light,
        /// `Light[2]` at byte 468.
        pub lights: [Light; 2],
        /// `int8_t` at byte 548.
        pub byte: i8,
        /// Padding.
        pub _padding_549: [u8; 3],
        /// `double` at byte 552.
        pub d: f64,
        /// `float16_t` at byte 560.
        pub half_float: u16,
        /// `uint16_t` at byte 562.
        pub u16: u16,
        /// Padding.
        pub _padding_564: [u8; 4],
        /// `int64_t` at byte 568.
        pub i64: i64,
        /// `uint64_t` at byte 576.
        pub r#type: u64,
        /// `dvec3` at byte 584.
        pub d3: [f64; 3],
        /// `device address` at byte 608.
        pub link: u64,
        /// `uint` at byte 616.
        pub last: u32,
        /// Padding.
        pub _padding_620: [u8; 4],
    }
    impl ::core::default::Default for Everything {
        fn default() -> Self {
            ::bytemuck::Zeroable::zeroed()
        }
    }
    const _: () = { assert!(::core::mem::size_of::<Everything>() == 624); assert!(::core::mem::offset_of!(Everything, f) == 0); assert!(::core::mem::offset_of!(Everything, v2) == 4); assert!(::core::mem::offset_of!(Everything, v3) == 12); assert!(::core::mem::offset_of!(Everything, v4) == 24); assert!(::core::mem::offset_of!(Everything, i) == 40); assert!(::core::mem::offset_of!(Everything, i2) == 44); assert!(::core::mem::offset_of!(Everything, i3) == 52); assert!(::core::mem::offset_of!(Everything, i4) == 64); assert!(::core::mem::offset_of!(Everything, u) == 80); assert!(::core::mem::offset_of!(Everything, u2) == 84); assert!(::core::mem::offset_of!(Everything, u3) == 92); assert!(::core::mem::offset_of!(Everything, u4) == 104); assert!(::core::mem::offset_of!(Everything, b) == 120); assert!(::core::mem::offset_of!(Everything, m2) == 124); assert!(::core::mem::offset_of!(Everything, m3) == 140); assert!(::core::mem::offset_of!(Everything, m4) == 176); assert!(::core::mem::offset_of!(Everything, m34) == 240); assert!(::core::mem::offset_of!(Everything, m43) == 288); assert!(::core::mem::offset_of!(Everything, floats) == 336); assert!(::core::mem::offset_of!(Everything, grid) == 356); assert!(::core::mem::offset_of!(Everything, light) == 428); assert!(::core::mem::offset_of!(Everything, lights) == 468); assert!(::core::mem::offset_of!(Everything, byte) == 548); assert!(::core::mem::offset_of!(Everything, d) == 552); assert!(::core::mem::offset_of!(Everything, half_float) == 560); assert!(::core::mem::offset_of!(Everything, u16) == 562); assert!(::core::mem::offset_of!(Everything, i64) == 568); assert!(::core::mem::offset_of!(Everything, r#type) == 576); assert!(::core::mem::offset_of!(Everything, d3) == 584); assert!(::core::mem::offset_of!(Everything, link) == 608); assert!(::core::mem::offset_of!(Everything, last) == 616); };

    /// `Light`, 40 bytes, as `every_type.comp` has it.
    #[repr(C)]
    #[derive(Clone, Copy, Debug, PartialEq, ::bytemuck::Pod, ::bytemuck::Zeroable)]
    pub struct Light {
        /// `vec3` at byte 0.
        pub position: ::glam::Vec3,
        /// `float` at byte 12.
        pub range: f32,
        /// `mat2x3` at byte 16.
        pub basis: [[f32; 3]; 2],
    }
    impl ::core::default::Default for Light {
        fn default() -> Self {
            ::bytemuck::Zeroable::zeroed()
        }
    }
    const _: () = { assert!(::core::mem::size_of::<Light>() == 40); assert!(::core::mem::offset_of!(Light, position) == 0); assert!(::core::mem::offset_of!(Light, range) == 12); assert!(::core::mem::offset_of!(Light, basis) == 16); };

    /// `Link`, 24 bytes, as `every_type.comp` has it.
    #[repr(C)]
    #[derive(Clone, Copy, Debug, PartialEq, ::bytemuck::Pod, ::bytemuck::Zeroable)]
    pub struct Link {
        /// `device address` at byte 0.
        pub next: u64,
        /// `vec3` at byte 8.
        pub color: ::glam::Vec3,
        /// Padding.
        pub _padding_20: [u8; 4],
    }
    impl ::core::default::Default for Link {
        fn default() -> Self {
            ::bytemuck::Zeroable::zeroed()
        }
    }
    const _: () = { assert!(::core::mem::size_of::<Link>() == 24); assert!(::core::mem::offset_of!(Link, next) == 0); assert!(::core::mem::offset_of!(Link, color) == 8); };

    /// `Nodes`, 4 bytes, as `every_type.comp` has it.
    #[repr(C)]
    #[derive(Clone, Copy, Debug, PartialEq, ::bytemuck::Pod, ::bytemuck::Zeroable)]
    pub struct Nodes {
        /// `uint` at byte 0.
        pub count: u32,
    }
    impl ::core::default::Default for Nodes {
        fn default() -> Self {
            ::bytemuck::Zeroable::zeroed()
        }
    }
    const _: () = { assert!(::core::mem::size_of::<Nodes>() == 4); assert!(::core::mem::offset_of!(Nodes, count) == 0); };

    /// `Sums`, 8 bytes, as `every_type.comp` has it.
    #[repr(C)]
    #[derive(Clone, Copy, Debug, PartialEq, ::bytemuck::Pod, ::bytemuck::Zeroable)]
    pub struct Sums {
        /// `uint` at byte 0.
        pub count: u32,
        /// Padding.
        pub _padding_4: [u8; 4],
    }
    impl ::core::default::Default for Sums {
        fn default() -> Self {
            ::bytemuck::Zeroable::zeroed()
        }
    }
    const _: () = { assert!(::core::mem::size_of::<Sums>() == 8); assert!(::core::mem::offset_of!(Sums, count) == 0); };

