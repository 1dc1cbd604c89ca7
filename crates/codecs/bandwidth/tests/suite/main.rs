//! Tests bandwidth maps through the public interface.

mod golden;
