"""The paper's reward rule: steps by rewards and penalties, with a virtual search."""
